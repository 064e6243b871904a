"""The default beside MoorDyn on equal meshes: every error, and how many times longer MoorDyn takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from benchmarks.cases import seen
from benchmarks.headline import QUANTITIES
from benchmarks.measures import MISSING, short
from benchmarks.methods import DEFAULT
from benchmarks.peers.compare import LINEAR, best

Points = Sequence[dict[str, Any]]
MESHES = (100, 200)


class Pair(NamedTuple):
    """An error (-) of the default, the least of MoorDyn's settings, and that one's time over ours."""

    mine: float
    theirs: float
    times: float


def pairs(points: Points, segments: int, quantity: str) -> dict[str, Pair]:
    """By case, of breaks at once: MoorDyn has no ramp. For each quantity its best setting by itself."""
    own = [p for p in points if p["segments"] == segments and p["case"] != LINEAR]
    found = {}
    for case in seen([p for p in own if p["program"] == "MoorDyn"])[0]:
        here = [p for p in own if p["case"] == case]
        mine = best([p for p in here if p["setting"] == DEFAULT], quantity)
        theirs = best([p for p in here if p["program"] == "MoorDyn"], quantity)
        if mine is not None and theirs is not None:
            found[case] = Pair(
                mine["errors"][quantity], theirs["errors"][quantity], theirs["warm"] / mine["warm"]
            )
    return found


def table(points: Points) -> str:
    """Errors in per cent and ratios of times by mesh, quantity and pretension."""
    cases, _ = seen([p for p in points if p["program"] == "MoorDyn" and p["case"] != LINEAR])
    pulls = " | ".join(case.split(",")[0] for case in cases)
    rows = [
        f"| at once: default / MoorDyn, % (its time over ours) | N | {pulls} | no worse |",
        "|---" * (len(cases) + 3) + "|",
    ]
    for quantity, words in QUANTITIES.items():
        for n in MESHES:
            found = pairs(points, n, quantity)
            if not found:
                continue
            cells = " | ".join(_cell(found.get(case)) for case in cases)
            good = sum(p.mine <= p.theirs for p in found.values())
            rows.append(f"| {words} | {n} | {cells} | {good} of {len(found)} |")
    return "\n".join(rows)


def settings_table(points: Points) -> str:
    """Each setting of MoorDyn's, as a run has it: in how many cases the default is no worse."""
    of = [p for p in points if p["case"] != LINEAR]
    theirs = [p for p in of if p["program"] == "MoorDyn"]
    words = " | ".join(QUANTITIES.values())
    rows = [
        f"| at once, MoorDyn's setting | N | {words} | together | its time over ours |",
        "|---" * (len(QUANTITIES) + 4) + "|",
    ]
    for n in MESHES:
        mine = {p["case"]: p for p in of if p["setting"] == DEFAULT and p["segments"] == n}
        for setting in dict.fromkeys(p["setting"] for p in theirs if p["segments"] == n):
            beside = [
                (mine[p["case"]], p)
                for p in theirs
                if (p["segments"], p["setting"]) == (n, setting) and p["case"] in mine
            ]
            # an error that is no number is of a run that came to nothing: it counts for the other
            good = [
                sum(not p["errors"][q] < own["errors"][q] for own, p in beside) for q in QUANTITIES
            ]
            times = [p["warm"] / own["warm"] for own, p in beside]
            each = " | ".join(f"{count} of {len(beside)}" for count in good)
            rows.append(
                f"| {setting} | {n} | {each} | {sum(good)} of {len(good) * len(beside)} "
                f"| {min(times):.0f} to {max(times):.0f} |"
            )
    return "\n".join(rows)


def _cell(pair: Pair | None) -> str:
    if pair is None:
        return MISSING
    return f"{short(100 * pair.mine)} / {short(100 * pair.theirs)} ({pair.times:.0f})"
