"""What can be wrong with the times of a record, and with tables in two lists."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from lumpedcable.scene.part import Problem

__all__ = ["gap_fault", "table_problems", "times_fault"]

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


def table_problems(
    key: str, at: Sequence[float], each: str, unit: str, values: Sequence[object], found: str,
    least: int = 2,
) -> Iterator[Problem]:  # fmt: skip
    """Yield lists of a table that are too short, of unequal length, or whose first does not increase.

    Args:
        key, at: the list that increases, under its key.
        each, unit: what one of it is, such as "height", and its unit.
        values: what stands beside each.
        found: the key of these, one of them in words.
        least: how many there are at least.
    """
    if len(at) < least:
        wanted = f"one {each}" if least == 1 else f"{least} {each}s"
        yield Problem((key,), f"expected at least {wanted}, found {len(at) or 'none'}")
    elif len(values) != len(at):
        several = found.removesuffix("y") + "ies" if found.endswith("y") else f"{found}s"
        words = f"expected {len(at)} {several}, one per {each}, found {len(values)}"
        yield Problem((found,), words)
    for i, (before, after) in enumerate(pairwise(at)):
        if after <= before:
            words = (
                f"expected more than {before:g} {unit}, the {each} before, found {after:g} {unit}"
            )
            yield Problem((key, i + 1), words)
            return
