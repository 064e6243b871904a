"""What the default method was asked to reach at N = 100, and whether it does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks import headline
from benchmarks.cases import PRETENSIONS
from benchmarks.floor import floor
from benchmarks.methods import DEFAULT
from benchmarks.reference import load

SEGMENTS = 100
SHOCKS = (315, 450)  # kN: released from above the inflection of the law


def table(points: Sequence[dict[str, Any]], peers: Sequence[dict[str, Any]]) -> str:
    """Target, found, met or not."""
    rows = [f"| default, N = {SEGMENTS}, break in 5 ms | asked | found | |", "|---|---|---|---|"]
    own = {
        p["case"]: p["errors"]
        for p in points
        if (p["method"], p["segments"]) == (DEFAULT, SEGMENTS) and p["case"].endswith("5 ms")
    }
    truths = load()
    asked: list[tuple[str, int, str, float, str]] = []
    for T0 in PRETENSIONS:
        asked.append(("end velocity", T0, "velocity", 1e-2, "%"))
        if T0 in SHOCKS:
            asked.append(("T_c", T0, "tension_fine", 1.5e-2, "%"))
            asked.append(("front", T0, "front", 1e-4, "ms"))
        else:
            asked.append(("tension", T0, "tension", 3e-3, "%"))
    for words, T0, key, limit, unit in asked:
        found = own.get(f"{T0} kN, 5 ms")
        if found is None:
            continue
        value, factor = abs(found[key]), 100 if unit == "%" else 1e3
        met = "met" if value <= limit else "not met"
        told = f"{factor * value:.2g} {unit}"
        if key == "tension_fine":
            least = floor(truths[f"{T0} kN, 5 ms"].histories, SEGMENTS)
            told += f" (a front as wide as a segment: {factor * least:.2g} {unit})"
        rows.append(f"| {words}, {T0} kN | {factor * limit:g} {unit} | {told} | {met} |")
    for quantity, words in headline.QUANTITIES.items():
        for case, ratio in headline.against_rk4(points, quantity).items():
            if case.endswith("5 ms"):
                rows.append(_ratio_row(f"{words} to 0.1 %, {case}", "RK4", 10, ratio))
    for quantity, words in headline.QUANTITIES.items():
        for case, found in headline.against_moordyn(points, peers, quantity).items():
            rows.append(
                _ratio_row(f"{words} to MoorDyn's best, {case}", "MoorDyn", 20, found["ratio"])
            )
    return "\n".join(rows)


def _ratio_row(what: str, whom: str, limit: float, ratio: str) -> str:
    """A ratio that is only bounded from above, or from below by less than is asked, decides nothing."""
    bound, _, number = ratio.rpartition(" ")
    if ratio == headline.BOTH:
        return f"| {what} | {limit:g} times faster than {whom} | {ratio} | open |"
    if ratio.endswith(("reached", "it")):
        return f"| {what} | {limit:g} times faster than {whom} | {ratio} | not met |"
    enough = float(number) >= limit
    open_ = bound == (">" if not enough else "<")
    met = "open" if open_ else "met" if enough else "not met"
    return f"| {what} | {limit:g} times faster than {whom} | {ratio} times | {met} |"
