"""The ends of a line by number, and how far in they reach; without jax, so that layouts are."""

__all__ = ["AFTER", "ALIKE", "BEFORE", "FALLEN"]

BEFORE, AFTER = 1, 2  # the ends at a cut, as 0 is a line's start and -1 its end
FALLEN = 5  # slack segments at an end, with which the line falls slack
# so much of the fastest rate of these: where the own segment is slack and the own rate, the next and the
# third are no slower, it falls slack as well
ALIKE = (1.0 / 5.0, 1.0 / 4.0, 1.0 / 3.0)
