"""The engine beside other programs, on the scenes of configs/peers."""
