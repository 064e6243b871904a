"""The engine and its peers on the same lines, in the same run, on the same machine."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.cases import MAIN, seen
from benchmarks.engine import Runner, scene_of
from benchmarks.measures import COARSE, Errors, Histories, errors
from benchmarks.methods import DEFAULT, METHODS
from benchmarks.peers import elastica_line, moordyn_line, scipy_line
from benchmarks.problem import Line, line_of
from benchmarks.reference import DURATION, load
from lumpedcable.exact import LinearRelease

Tell = Callable[[str], None]

MESHES = (50, 100, 200, 400)
# a linear line in vacuum until just before its front meets the wall
HOOKE = (
    "materials.nylon={law='linear', EA='1 MN'}", "rope.length=100 m", "rope.mass=1", "break.time=0",
    "rope.drag.tangential=0", "output.duration=90 ms",
)  # fmt: skip
LINEAR = "linear line, at once"
LINEAR_PULL = {"PyElastica": 500.0}  # N, of a small strain; 50 kN, 5 %, for the others
# what a program needs; SciPy itself is always there
PACKAGES = {"MoorDyn": "moordyn", "SciPy": "numba", "PyElastica": "pyelastica"}
SOLVERS: dict[str, Any] = {
    "MoorDyn": moordyn_line, "SciPy": scipy_line, "PyElastica": elastica_line,
}  # fmt: skip
ENGINE = tuple(m for m in METHODS if m.name in (DEFAULT, "leapfrog, plain", "RK4, plain"))


def run(quick: bool, tell: Tell) -> dict[str, Any]:
    """Every program on every mesh; of a peer's settings all, so that its best can be shown."""
    versions = {name: version(package) for name, package in PACKAGES.items()}
    points: list[dict[str, Any]] = []
    meshes = (100,) if quick else MESHES
    for name in [c.name for c in MAIN if not quick or c.name.startswith(("45 kN", "450 kN"))] + [
        LINEAR
    ]:
        for n in meshes:
            points += _engine(name, n, tell)
            for peer in SOLVERS:
                if versions[peer] is not None and _can(peer, name):
                    points += _peer(peer, name, n, quick, tell)
    return {"points": points, "versions": versions}


def version(package: str) -> str | None:
    """The installed version of a package, None without it."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _can(peer: str, case: str) -> bool:
    if peer == "MoorDyn":
        return case.endswith("at once")
    return peer == "SciPy" or case == LINEAR


def _changes(case: str, pull: float = 50e3) -> tuple[str, ...]:
    if case == LINEAR:
        return (*HOOKE, f"pretension={pull}")
    return next(c.changes for c in MAIN if c.name == case)


def exact_linear(line: Line, duration: float) -> Histories:
    """The linear line in vacuum by d'Alembert."""
    exact = LinearRelease(line.length, float(line.slope(0.01)), line.mass, line.pull)
    t = np.arange(round(duration / COARSE) + 1) * COARSE
    velocity = -exact.end_velocity(t)
    velocity[0] = 0.0  # the state before the break, as all programs give it
    moved = -float(exact.end_displacement(t[-1]))
    return Histories(t, exact.wall_tension(t), velocity, moved, np.nan)


def _errors(case: str, line: Line, found: Histories, fine: Histories) -> Errors:
    if case == LINEAR:
        truth = exact_linear(line, float(found.time[-1]))
        got = errors(found, truth)
        # the front does not reach the wall
        return got._replace(tension=np.nan, tension_fine=np.nan, front=np.nan)
    return errors(found, load()[case].histories, fine)


def _engine(case: str, segments: int, tell: Tell) -> list[dict[str, Any]]:
    found = []
    for method in ENGINE:
        tell(f"lumpedcable, {method.name}, {segments} segments, {case}")
        scene = scene_of(*_changes(case), *method.changes, f"segments={segments}")
        runner = Runner(scene, method.stretch)
        timed = runner.run()
        e = _errors(case, line_of(scene), timed.histories, runner.fine())
        found.append(
            _record("lumpedcable", method.name, case, segments, e, timed.warm,
                    max(timed.first - timed.warm, 0.0), timed.steps, "steps", timed.status.name)
        )  # fmt: skip
    return found


def _peer(peer: str, case: str, segments: int, quick: bool, tell: Tell) -> list[dict[str, Any]]:
    module, found = SOLVERS[peer], []
    pull = LINEAR_PULL.get(peer, 50e3)
    line = line_of(scene_of(*_changes(case, pull)))
    duration = 0.09 if case == LINEAR else DURATION
    settings: tuple[Any, ...] = module.SETTINGS
    if segments > 100:
        settings = getattr(module, "FINE_SETTINGS", settings)
    for setting in settings[:: 2 if quick else 1]:
        tell(f"{peer}, {setting}, {segments} segments, {case}")
        try:
            out = module.solve(line, segments, setting, duration)
        except Exception as error:
            found.append(
                _record(peer, _words(setting), case, segments, Errors(*[np.nan] * 5), np.nan, np.nan,
                        0, "steps", f"{type(error).__name__}: {error}")
            )  # fmt: skip
            continue
        e = _errors(case, line, out.histories, out.fine)
        found.append(
            _record(peer, _words(setting), case, segments, e, out.warm, out.compile, out.steps,
                    out.unit, out.status)
        )  # fmt: skip
    return found


def _words(setting: Any) -> str:
    parts = setting if isinstance(setting, tuple) else (setting,)
    return ", ".join(part if isinstance(part, str) else f"{part:g}" for part in parts)


def _record(
    program: str, setting: str, case: str, segments: int, e: Errors, warm: float, compiling: float,
    steps: int, unit: str, status: str,
) -> dict[str, Any]:  # fmt: skip
    return {
        "program": program, "setting": setting, "case": case, "segments": segments,
        "errors": e._asdict(), "warm": warm, "compile": compiling, "steps": steps, "unit": unit,
        "status": status,
    }  # fmt: skip


def table(points: Sequence[dict[str, Any]], kind: str, segments: int | None = None) -> str:
    """Errors and times by program and mesh; of a peer's settings the best for each quantity.

    Of one mesh alone where `segments` is given.
    """
    points = [p for p in points if p["case"].endswith(kind) and p["case"] != LINEAR]
    points = [p for p in points if segments in (None, p["segments"])]
    cases, pulls = seen(points)
    rows = [
        f"| break {kind}, {pulls} kN | N | end displacement, % | end velocity, % | its time, ms "
        "| T_c, % | its time, ms |",
        "|---|---|---|---|---|---|---|",
    ]
    for program, setting in _who(points):
        for n in sorted({p["segments"] for p in points}):
            cells: list[list[str]] = [[], [], [], [], []]
            for case in cases:
                own = [
                    p for p in points
                    if (p["program"], p["case"], p["segments"]) == (program, case, n)
                    and setting in (None, p["setting"])
                ]  # fmt: skip
                moved, speed, pull = (
                    best(own, key) for key in ("displacement", "velocity", "tension_fine")
                )
                cells[0].append(_percent(moved, "displacement"))
                cells[1].append(_percent(speed, "velocity"))
                cells[2].append(_time(speed))
                cells[3].append(_percent(pull, "tension_fine"))
                cells[4].append(_time(pull))
            name = program if setting is None else f"lumpedcable, {setting}"
            rows.append(f"| {name} | {n} | {' | '.join(' / '.join(c) for c in cells)} |")
    return "\n".join(rows)


def linear_table(points: Sequence[dict[str, Any]]) -> str:
    """The linear line: end velocity and displacement against d'Alembert, best of each peer."""
    points = [p for p in points if p["case"] == LINEAR]
    meshes = sorted({p["segments"] for p in points})
    rows = [
        "| linear line, end velocity, % (its time, ms) | "
        + " | ".join(f"N = {n}" for n in meshes) + " |",
        "|---" * (len(meshes) + 1) + "|",
    ]  # fmt: skip
    for program, setting in _who(points):
        cells = []
        for n in meshes:
            own = [
                p for p in points
                if (p["program"], p["segments"]) == (program, n) and setting in (None, p["setting"])
            ]  # fmt: skip
            found = best(own, "velocity")
            cells.append(f"{_percent(found, 'velocity')} ({_time(found)})")
        name = program if setting is None else f"lumpedcable, {setting}"
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def damping_table(points: Sequence[dict[str, Any]], segments: int = 100) -> str:
    """What MoorDyn's settings do, at one mesh."""
    points = [
        p for p in points
        if (p["program"], p["segments"]) == ("MoorDyn", segments) and p["case"] != LINEAR
    ]  # fmt: skip
    cases, pulls = seen(points)
    rows = [
        f"| MoorDyn, N = {segments}, {pulls} kN: scheme, step, damping | end velocity, % | T_c, % "
        "| time, ms |",
        "|---|---|---|---|",
    ]
    for setting in dict.fromkeys(p["setting"] for p in points):
        own = [
            next((p for p in points if (p["case"], p["setting"]) == (c, setting)), None)
            for c in cases
        ]
        cells = [" / ".join(_percent(p, key) for p in own) for key in ("velocity", "tension_fine")]
        rows.append(f"| {setting} | {' | '.join(cells)} | {' / '.join(map(_time, own))} |")
    return "\n".join(rows)


def best(points: Sequence[dict[str, Any]], quantity: str) -> dict[str, Any] | None:
    """The point with the smallest error; None where there is none."""
    good = [p for p in points if np.isfinite(p["errors"][quantity])]
    return min(good, key=lambda p: p["errors"][quantity]) if good else None


def _who(points: Sequence[dict[str, Any]]) -> list[tuple[str, str | None]]:
    """Rows of a table: the engine by method, peers as a whole."""
    return list(
        dict.fromkeys(
            (p["program"], p["setting"] if p["program"] == "lumpedcable" else None) for p in points
        )
    )


def _percent(point: dict[str, Any] | None, quantity: str) -> str:
    return "-" if point is None else f"{100 * point['errors'][quantity]:.2g}"


def _time(point: dict[str, Any] | None) -> str:
    return "-" if point is None else f"{1e3 * point['warm']:.3g}"
