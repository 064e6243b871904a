"""The ends of a line by number, and how far in they reach; without jax, so that layouts are."""

__all__ = ["AFTER", "BEFORE", "FALLEN"]

BEFORE, AFTER = 1, 2  # the ends at a cut, as 0 is a line's start and -1 its end
FALLEN = 5  # slack segments at an end, with which the line falls slack
