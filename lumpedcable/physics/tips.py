"""The ends of a line by number; without jax, so that layouts are."""

__all__ = ["AFTER", "BEFORE"]

BEFORE, AFTER = 1, 2  # the ends at a cut, as 0 is a line's start and -1 its end
