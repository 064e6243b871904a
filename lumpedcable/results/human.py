"""SI values in the units people speak in: 45000 N is 45 kN, 0.005 s is 5 ms, pi rad is 180 deg."""

from __future__ import annotations

import math
from collections.abc import Iterable

_STEPS = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
# units that take prefixes, with the largest one in use for each: nobody speaks of kiloseconds
_LARGEST = {"N": 1e9, "J": 1e9, "W": 1e9, "Pa": 1e9, "Hz": 1e9, "m": 1e3, "s": 1.0}


def scale(largest: float, unit: str) -> tuple[float, str]:
    """The factor and the unit in which values up to `largest` read well.

    Args:
        largest: the largest magnitude to be shown, in `unit`.
        unit: an SI unit such as "N", "N m2" or "m/s"; only a leading unit that people prefix gets a
            prefix, so m/s and kg/m3 stay as they are.

    Returns:
        (factor, text): value * factor is in units of text. (1e-3, "kN") for 45000 and "N".
    """
    if unit == "rad":
        return math.degrees(1.0), "deg"
    head, _, tail = unit.partition(" ")
    if head not in _LARGEST or not math.isfinite(largest) or largest == 0:
        return 1.0, "" if unit == "1" else unit
    # a hair's breadth of slack: 1000 N computed as 999.9999999 is still 1 kN
    fitting = (
        step
        for step in _STEPS
        if step[0] <= _LARGEST[head] and abs(largest) >= step[0] * (1 - 1e-9)
    )
    step, prefix = next(fitting, _STEPS[-1])
    return 1 / step, f"{prefix}{head} {tail}".rstrip()


def quantity(value: float, unit: str, digits: int = 6) -> str:
    """A value with its unit as text to so many digits, e.g. "45 kN", "5 ms", "0.3"."""
    factor, text = scale(value, unit)
    return f"{value * factor:.{digits}g} {text}".rstrip()


def size(count: int) -> str:
    """A number of bytes as text, e.g. "3.2 MB"."""
    value, text = float(count), "B"
    for text in ("B", "kB", "MB", "GB", "TB"):
        if value < 1000 or text == "TB":
            break
        value /= 1000
    return f"{value:.3g} {text}"


def same_words(told: Iterable[tuple[int, str]]) -> list[tuple[list[int], str]]:
    """Numbers of runs (rising) by what is told of them, in the order of the first of each."""
    found: dict[str, list[int]] = {}
    for run, words in told:
        found.setdefault(words, []).append(run)
    return [(runs, words) for words, runs in found.items()]


def runs_named(runs: list[int], most: int = 8) -> str:
    """Numbers of runs (rising) as text: "run 3", "runs 0, 2 and 5 to 7"; of gaps at most so many."""
    spans: list[list[int]] = []
    for run in runs:
        if spans and run == spans[-1][-1] + 1:
            spans[-1].append(run)
        else:
            spans.append([run])
    if len(spans) > most:
        spans = spans[: most - 1]
    each = []
    for span in spans:
        each += [f"{span[0]} to {span[-1]}"] if len(span) > 2 else map(str, span)
    left = len(runs) - sum(map(len, spans))
    *before, last = [*each, f"{left} more"] if left else each
    return f"run{'s' * (len(runs) > 1)} {', '.join(before)}{' and ' * bool(before)}{last}"


def first_told(told: Iterable[tuple[int, str]], most: int, rest: str) -> tuple[list[str], str]:
    """The first so many things that are told of runs, and how many more there are `rest`, or ""."""
    every = same_words(told)
    left = sum(len(runs) for runs, _ in every[most:])
    more = f"and {left} more run{'' if left == 1 else 's'} {rest}" if left else ""
    return [f"{runs_named(runs)}: {words}" for runs, words in every[:most]], more
