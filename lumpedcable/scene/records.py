"""What can be wrong with the times of a record."""

from collections.abc import Sequence
from itertools import pairwise

__all__ = ["gap_fault", "times_fault"]

# a record is torn where a step of time is so many times the usual one, be it irregular or even
GAP, EVEN_GAP = 10.0, 1.5


def times_fault(time: Sequence[float]) -> str | None:
    """Return what is wrong with the number or the order of times (s), or None."""
    if len(time) < 2:
        return f"expected at least 2 times, found {len(time)}"
    for before, after in pairwise(time):
        if after <= before:
            return f"expected times that increase, found {after:g} s after {before:g} s"
    return None


def gap_fault(time: Sequence[float], rows: Sequence[Sequence[float]] = ()) -> str | None:
    """Return where times (s) that increase leave a gap, or None.

    What rests there, before and after, has none: `rows` are what is recorded at these times.
    """
    steps = [after - before for before, after in pairwise(time)]
    usual = sorted(steps)[len(steps) // 2]
    even = sum(abs(step - usual) <= 0.01 * usual for step in steps) >= 0.8 * len(steps)
    for k, (before, step) in enumerate(zip(time, steps, strict=False)):
        if step <= (EVEN_GAP if even else GAP) * usual:
            continue
        rests = rows and all(len(set(row[max(k - 1, 0) : k + 3])) == 1 for row in rows)
        if not rests:
            return (
                f"expected a record without gaps, a value about every {usual:g} s, found none "
                f"between {before:g} s and {before + step:g} s"
            )
    return None
