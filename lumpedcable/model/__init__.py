"""The assembly: kinematics once, forces summed, masses, one residual.

Written once and used by dynamics (which integrates it), statics (which finds its root) and whatever
linearises or differentiates it. Knows nothing of solvers and files.
"""
