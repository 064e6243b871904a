"""How long until an error of 1, 0.3 or 0.1 % is reached, and how that compares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.cases import MAIN
from benchmarks.methods import DEFAULT, RK4, USABLE

LEVELS = (1e-2, 3e-3, 1e-3)
QUANTITIES = {
    "displacement": "end displacement", "velocity": "end velocity",
    "tension": "tension at 1 ms samples", "tension_fine": "T_c",
}  # fmt: skip
BOTH = "both on their coarsest mesh"
Points = Sequence[dict[str, Any]]


class Reached(NamedTuple):
    """Time (s) at which an error is reached; `bound` is "<" or ">" where it is only bounded.

    "<": the coarsest mesh is already below it. ">": no mesh reaches it; the time is that of the
    finest.
    """

    time: float
    bound: str = ""

    def text(self) -> str:
        """In ms."""
        if self.bound == ">":
            return "not reached"
        return f"{self.bound}{1e3 * self.time:.3g}"


def reached(times: Sequence[float], errors: Sequence[float], level: float) -> Reached:
    """When the error falls below a level for good, with finer meshes, straight in logarithms between.

    `times` and `errors` run from the coarsest mesh to the finest. An error that is small by chance
    on one mesh and larger on the next does not count.
    """
    t = np.asarray(times, float)
    e = np.where(np.isfinite(errors), errors, np.inf)
    e = np.maximum.accumulate(e[::-1])[::-1]
    if e[-1] > level:
        return Reached(float(t[-1]), ">")
    first = int(np.argmax(e <= level))
    if first == 0:
        return Reached(float(t[0]), "<")
    if not np.isfinite(e[first - 1]):
        return Reached(float(t[first]))
    before, after = np.log(e[first - 1]), np.log(e[first])
    share = (before - np.log(level)) / (before - after)
    return Reached(float(np.exp((1 - share) * np.log(t[first - 1]) + share * np.log(t[first]))))


def history(points: Points, quantity: str, **which: str) -> tuple[list[float], list[float]]:
    """Times and errors of the points that match, by mesh; runs without a history are left out."""
    own = [p for p in points if all(p[key] == value for key, value in which.items())]
    own.sort(key=lambda p: p["segments"])
    own = [p for p in own if p["status"] in USABLE]
    return [p["warm"] for p in own], [p["errors"][quantity] for p in own]


def table(points: Points, quantity: str, cases: Sequence[str]) -> str:
    """Time in ms to each level by method and pretension."""
    cases = [c for c in cases if any(p["case"] == c for p in points)]
    pulls = [c.split(",")[0] for c in cases]
    rows = [
        "| time in ms to an error of | "
        + " | ".join(f"{100 * level:g} %, {pull}" for level in LEVELS for pull in pulls) + " |",
        "|---" * (len(LEVELS) * len(cases) + 1) + "|",
    ]  # fmt: skip
    for name in dict.fromkeys(p["method"] for p in points):
        if not any(p["method"] == name and p["case"] in cases for p in points):
            continue
        cells = []
        for level in LEVELS:
            for case in cases:
                found = history(points, quantity, method=name, case=case)
                cells.append(reached(*found, level).text() if found[0] else "")
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def ratio(a: Reached, b: Reached) -> str:
    """How many times longer a takes than b, in words."""
    if a.bound == b.bound == "<":
        return BOTH
    if b.bound == ">":
        return "neither reaches it" if a.bound == ">" else "not reached"
    sign = "> " if a.bound == ">" or b.bound == "<" else "< " if a.bound == "<" else ""
    return f"{sign}{a.time / b.time:.3g}"


def against_rk4(points: Points, quantity: str, level: float = 1e-3) -> dict[str, str]:
    """RK4's time to a level over that of the default, by case."""
    found = {}
    for case in (c.name for c in MAIN if any(p["case"] == c.name for p in points)):
        slow, fast = (history(points, quantity, method=m, case=case) for m in (RK4, DEFAULT))
        if slow[0] and fast[0]:
            found[case] = ratio(reached(*slow, level), reached(*fast, level))
    return found


def against_moordyn(points: Points, peers: Points, quantity: str) -> dict[str, dict[str, Any]]:
    """At MoorDyn's best error, over all its meshes and settings: both times, by case."""
    found = {}
    for case in (c.name for c in MAIN):
        own = [
            p for p in peers
            if (p["program"], p["case"]) == ("MoorDyn", case) and p["errors"][quantity] is not None
            and np.isfinite(p["errors"][quantity])
        ]  # fmt: skip
        fast = history(points, quantity, method=DEFAULT, case=case)
        if not own or not fast[0]:
            continue
        best = min(own, key=lambda p: p["errors"][quantity])
        level = best["errors"][quantity]
        mine = reached(*fast, level)
        found[case] = {
            "error": level, "segments": best["segments"], "setting": best["setting"],
            "moordyn": best["warm"], "default": mine.text(),
            "ratio": ratio(Reached(best["warm"]), mine),
        }  # fmt: skip
    return found


def ratios(points: Points, peers: Points) -> str:
    """The table of both ratios."""
    rows = []
    for quantity, words in QUANTITIES.items():
        for case, value in against_rk4(points, quantity).items():
            rows.append(f"| {words} | {case} | RK4, plain | 0.1 % | | | {value} |")
        for case, found in against_moordyn(points, peers, quantity).items():
            rows.append(
                f"| {words} | {case} | MoorDyn, N = {found['segments']} | "
                f"{100 * found['error']:.2g} % | {1e3 * found['moordyn']:.3g} | {found['default']} "
                f"| {found['ratio']} |"
            )
    head = (
        "| quantity | case | against | at an error of | its time, ms | the default's, ms | ratio |"
    )
    return "\n".join([head, "|---|---|---|---|---|---|---|", *rows])
