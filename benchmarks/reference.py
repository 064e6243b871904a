"""Converged answers for the parted line, by finite volumes.

`python -m benchmarks.reference` makes them anew, in some 20 minutes. They are kept in reference.npz with
what halving the number of cells changes; `python -m benchmarks reference` shows that the scheme is right
where there is an exact answer, and how far from it the engine is on a fine mesh.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.cases import HELD_OUT, MAIN, Case, seen
from benchmarks.engine import Runner, scene_of
from benchmarks.measures import (
    COARSE,
    ERROR_HEADS,
    FINE,
    Errors,
    Histories,
    error_cells,
    errors,
    relative,
)
from benchmarks.problem import Line, line_of
from benchmarks.volumes import Cells, solve
from lumpedcable.exact import LinearRelease, ramped_release, release_wave

FILE = Path(__file__).with_name("reference.npz")
DURATION = 0.2  # s
CELLS = {"main": 12800, "held out": 6400}
COARSE_CELLS = 100  # as many as the segments of the engine's tables


class Reference(NamedTuple):
    """A converged answer, the cells that it took, and its distance from that of half as many."""

    histories: Histories
    cells: int
    distance: Errors


def make(case: Case, cells: int) -> Reference:
    """The answer to a case, and to half as many cells."""
    line = line_of(scene_of(*case.changes))
    rough, found = (
        solve(line, n, DURATION, FINE, lambda share, n=n: _tell(f"{case.name}: {n} cells", share))
        for n in (cells // 2, cells)
    )
    return Reference(found, cells, errors(rough, found))


def _tell(what: str, share: float) -> None:
    if sys.stderr.isatty():
        print(f"\r{what}, {100 * share:.0f} %   ", end="", file=sys.stderr, flush=True)


def save(found: dict[str, Reference]) -> None:
    """Into one compressed file: tensions at 0.1 ms and velocities at 1 ms in single precision."""
    histories = [r.histories for r in found.values()]
    stride = round(COARSE / FINE)
    np.savez_compressed(
        FILE,
        name=np.array(list(found)),
        cells=np.array([r.cells for r in found.values()]),
        distance=np.array([r.distance for r in found.values()]),
        displacement=np.array([h.displacement for h in histories]),
        front=np.array([h.front for h in histories]),
        tension=np.array([h.tension for h in histories], np.float32),
        velocity=np.array([h.velocity[::stride] for h in histories], np.float32),
    )


def load() -> dict[str, Reference]:
    """All references by the name of their case."""
    found = {}
    with np.load(FILE) as file:
        columns = [file[key] for key in ("name", "cells", "distance", "displacement", "front")]
        tension, velocity = file["tension"].astype(float), file["velocity"].astype(float)
    time = np.arange(tension.shape[1]) * FINE
    coarse = np.arange(velocity.shape[1]) * COARSE
    for k, (name, cells, distance, moved, front) in enumerate(zip(*columns, strict=True)):
        v = np.interp(time, coarse, velocity[k])
        histories = Histories(time, tension[k], v, float(moved), float(front))
        found[str(name)] = Reference(histories, int(cells), Errors(*map(float, distance)))
    return found


class Check(NamedTuple):
    """A comparison of the scheme with an exact answer: relative L2 errors by number of cells."""

    name: str
    quantity: str
    error: dict[int, float]


def checks(meshes: tuple[int, ...]) -> list[Check]:
    """The scheme against the exact answers that there are without drag."""
    line = replace(line_of(scene_of()), drag=0.0)
    hooke = replace(
        line, law=(0.0, 1.0, 0.0, 0.0, 1.5e6), cut=False, pull=150e3, break_time=5e-3
    )  # fmt: skip
    found = [
        Check("linear law, reflections, 5 ms", quantity, {}) for quantity in ("tension", "velocity")
    ]
    found += [
        Check("180 kN, 5 ms, before the reflection", "velocity", {}),
        Check("450 kN, at once, before the reflection", "velocity", {}),
        Check("450 kN, at once, along the line at 40 ms", "strain", {}),
    ]
    for n in meshes:
        values = (*_against_images(hooke, n), _against_ramp(replace(line, pull=180e3), n))
        values += _against_shock(replace(line, pull=450e3, break_time=0.0), n)
        for check, value in zip(found, values, strict=True):
            check.error[n] = value
    return found


def _against_images(line: Line, cells: int) -> tuple[float, float]:
    exact = LinearRelease(line.length, line.law[4], line.mass, line.pull, line.break_time)
    found = solve(line, cells, DURATION, COARSE)
    return (
        relative(found.tension, exact.wall_tension(found.time)),
        relative(found.velocity, -exact.end_velocity(found.time)),
    )


def _against_ramp(line: Line, cells: int) -> float:
    exact = ramped_release(
        line.tension, line.mass, line.break_time, tension0=line.pull, derivative=line.slope
    )
    last = np.floor(exact.end_valid_until(line.length) / COARSE) * COARSE
    found = solve(line, cells, min(last, DURATION), COARSE)
    return relative(found.velocity, -exact.end_velocity(found.time))


def _against_shock(line: Line, cells: int) -> tuple[float, float]:
    exact = release_wave(line.tension, line.mass, tension0=line.pull, derivative=line.slope)
    duration = 0.04
    found = solve(line, cells, duration, COARSE)
    mesh = Cells(line, cells)
    steps = int(np.ceil(duration * mesh.fastest / (0.9 * mesh.width)))
    for i in range(steps):
        mesh.step(i * duration / steps, duration / steps)
    place = line.length - (np.arange(cells) + 0.5) * mesh.width
    strain = exact.strain(place / duration)
    # in the mean, not squared: a jump smeared over some cells has no order in squares
    profile = np.sum(np.abs(mesh.strain - strain)) / np.sum(np.abs(strain))
    return relative(found.velocity[1:], np.full(found.time.size - 1, -exact.end_speed)), profile


def run(quick: bool, tell: Callable[[str], None]) -> dict[str, Any]:
    """The scheme against exact answers, and a fine mesh of the engine against what is stored."""
    tell("finite volumes against exact answers")
    found = [check._asdict() for check in checks((100, 200) if quick else (200, 400, 800, 1600))]
    segments, known = 400 if quick else 6400, load()
    coarse, rows = [], []
    for case in (c for c in MAIN if not quick or c.name.startswith("45 kN")):
        stored = known[case.name]
        tell(f"{case.name}, finite volumes with {COARSE_CELLS} cells")
        rough = solve(line_of(scene_of(*case.changes)), COARSE_CELLS, DURATION, FINE)
        wrong = errors(rough, stored.histories)
        coarse.append({"case": case.name, "errors": wrong._asdict()})
        tell(f"{case.name}, engine with {segments} segments")
        ran = Runner(scene_of(*case.changes, f"segments={segments}")).fine()
        distance = errors(ran, stored.histories)
        rows.append({
            "case": case.name, "cells": stored.cells, "stored": stored.distance._asdict(),
            "segments": segments, "engine": distance._asdict(),
        })  # fmt: skip
    return {"checks": found, "engine": rows, "coarse": coarse}


def tables(data: dict[str, Any]) -> dict[str, str]:
    """Both as Markdown tables."""
    meshes = [str(n) for n in data["checks"][0]["error"]]
    exact = [
        f"| without drag, finite volumes against the exact answer | quantity | {' | '.join(meshes)} "
        "cells |",
        "|---" * (len(meshes) + 2) + "|",
    ]
    for check in data["checks"]:
        cells = " | ".join(f"{value:.1e}" for value in check["error"].values())
        exact.append(f"| {check['name']} | {check['quantity']} | {cells} |")
    words = ("end displacement", "end velocity", "tension", "T_c", "front, ms")
    segments = data["engine"][0]["segments"]
    rows = [
        "| distance from the reference: half as many cells / engine, "
        f"N = {segments} | {' | '.join(words)} |",
        "|---" * (len(words) + 1) + "|",
    ]
    for row in data["engine"]:
        cells = []
        for key in Errors._fields:
            a, b = row["stored"][key], row["engine"][key]
            if key == "front":
                cells.append(f"{1e3 * a:+.4f} / {1e3 * b:+.4f}")
            else:
                cells.append(f"{a:.1e} / {b:.1e}")
        rows.append(f"| {row['case']} | {' | '.join(cells)} |")
    return {
        "exact": "\n".join(exact), "distance": "\n".join(rows), "coarse": _coarse(data["coarse"])
    }  # fmt: skip


def _coarse(found: list[dict[str, Any]]) -> str:
    """What the scheme leaves on a coarse mesh, by kind of break."""
    rows = []
    for kind in ("5 ms", "at once"):
        mine = [row for row in found if row["case"].endswith(kind)]
        _, pretensions = seen(mine)
        if not rows:
            rows = [f"| finite volumes, {COARSE_CELLS} cells, {pretensions} kN | {ERROR_HEADS} |"]
            rows.append("|---|---|---|---|---|---|")
        cells = error_cells([row["errors"] for row in mine])
        rows.append(f"| break {kind} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main() -> None:
    """Make all references anew."""
    found = {}
    for kind, cases in (("main", MAIN), ("held out", HELD_OUT)):
        for case in cases:
            found[case.name] = make(case, CELLS[kind])
            told = ", ".join(f"{x:.1e}" for x in found[case.name].distance)
            print(f"\r\033[K{case.name}: half as many cells change {told}", flush=True)
    save(found)


if __name__ == "__main__":
    main()
