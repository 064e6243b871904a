"""What inextensible lines, bodies with friction and a stop ask of the solver and the rest of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import WinchEnd, reel_key
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import SIDES, Problem, did_you_mean
from lumpedcable.scene.run import ROUNDING, Output, Solver
from lumpedcable.scene.units import format_quantity

__all__ = ["stepping_problems"]

Lines = Mapping[str, Line | None]


def stepping_problems(
    lines: Lines,
    bodies: Mapping[str, Any],
    materials: Mapping[str, Any],
    events: Mapping[str, Any],
    others: Mapping[str, Any],
) -> Iterator[Problem]:
    """Yield what is asked for and not found; None stands for the unreadable."""
    solver = others.get("solver", Solver())
    yield from _stop(bodies, others.get("output"), solver)
    yield from _long_step(solver, others.get("output"))
    if not isinstance(solver, Solver) or None in lines.values():
        return
    known = {name: line for name, line in lines.items() if line is not None}
    laws = {name: getattr(materials.get(x.material), "law", None) for name, x in known.items()}
    rigid = {name: known[name] for name, law in laws.items() if law == "inextensible"}
    yield from _bed(bodies, others.get("seabed"), solver)
    yield from _top_speed(known, solver)
    if not rigid:
        yield from _gripping(bodies, solver)
        return
    for name, law in laws.items():
        if law not in ("inextensible", None):
            yield Problem(
                ("lines", name, "material"),
                f'expected an inextensible material, as of "{next(iter(rigid))}", '
                f'found law = "{law}"',
            )
    yield from _rod_solver(solver)
    yield from _rod_company(bodies, events)
    yield from _rod_lines(rigid)


def _stop(bodies: Mapping[str, Any], output: Any, solver: Any) -> Iterator[Problem]:
    """A body whose end of motion ends the run must move, in steps at each of which it is looked at."""
    if not isinstance(output, Output) or output.stop is None:
        return
    if isinstance(solver, Solver) and solver.adaptive:
        yield Problem(
            ("output", "stop"),
            "expected solver.step or solver.courant where the rest of a body ends the run, found "
            f'"{solver.method}", which chooses its steps itself',
        )
    moving = [n for n, b in bodies.items() if b is None or any(getattr(b, "velocity", None) or ())]
    if output.stop not in moving:
        told = did_you_mean(output.stop, moving) or f"; known: {', '.join(moving) or 'none'}"
        yield Problem(
            ("output", "stop"),
            f'expected a body that starts with a velocity, found "{output.stop}"{told}',
        )


def _long_step(solver: Any, output: Any) -> Iterator[Problem]:
    """A step ends where a state is kept, so that none can be longer than the time between two."""
    if not isinstance(solver, Solver) or not isinstance(output, Output):
        return
    if solver.step is not None and output.every and solver.step > output.every * (1.0 + ROUNDING):
        yield Problem(
            ("solver", "step"),
            f"expected at most output.every, {format_quantity(output.every, 's')}, found "
            f"{format_quantity(solver.step, 's')}",
        )


def _top_speed(lines: Mapping[str, Line], solver: Solver) -> Iterator[Problem]:
    """The step in which a winch comes to its bound ends beyond it, unless it is clipped or an error."""
    if solver.method == "leapfrog" or solver.adaptive:
        return
    for name, line in lines.items():
        for side in SIDES:
            end = getattr(line, side)
            if isinstance(end, WinchEnd) and end.winch.speed is not None:
                yield Problem(
                    ("lines", name, side, "winch", "speed"),
                    'expected solver.method = "leapfrog" or one that chooses its steps where a winch '
                    f'has a largest speed, found "{solver.method}" with fixed steps',
                )


def _bed(bodies: Mapping[str, Any], seabed: Any, solver: Solver) -> Iterator[Problem]:
    if getattr(seabed, "friction", None) is not None and solver.method != "leapfrog":
        yield Problem(
            ("seabed", "friction"),
            f'expected solver.method = "leapfrog" where the bed has friction, found "{solver.method}"',
        )
    if getattr(seabed, "profile", None) is None:
        return
    for name in _with_friction(bodies):
        yield Problem(
            ("bodies", name, "friction"),
            "expected a flat seabed where a body has friction, found one with a profile",
        )


def _gripping(bodies: Mapping[str, Any], solver: Solver) -> Iterator[Problem]:
    if solver.method == "leapfrog":
        return
    for name in _with_friction(bodies):
        yield Problem(
            ("bodies", name, "friction"),
            'expected solver.method = "leapfrog" where a body has friction, found '
            f'"{solver.method}"',
        )


def _with_friction(bodies: Mapping[str, Any]) -> Iterator[str]:
    for name, body in bodies.items():
        if isinstance(body, Body) and body.friction is not None:
            yield name


def _rod_solver(solver: Solver) -> Iterator[Problem]:
    if solver.step is None:
        yield Problem(
            ("solver", "step"), "expected a step (s) where lines are inextensible, found nothing"
        )
    if "method" in solver.model_fields_set and solver.method != "leapfrog":
        yield Problem(
            ("solver", "method"),
            f'expected "leapfrog" where lines are inextensible, found "{solver.method}"',
        )
    if solver.dtype != "float64":
        # rods have their lengths to rounding over step squared, which single precision has no digits for
        yield Problem(
            ("solver", "dtype"),
            f'expected "float64" where lines are inextensible, found "{solver.dtype}"',
        )


def _rod_company(bodies: Mapping[str, Any], events: Mapping[str, Any]) -> Iterator[Problem]:
    """What does not go with inextensible lines in one scene."""
    for name in events:
        yield Problem(("events", name), "expected no event where lines are inextensible, found one")
    for name, body in bodies.items():
        if getattr(body, "on", None) is not None:
            yield Problem(
                ("bodies", name, "on"),
                "expected elastic lines under a trolley, found inextensible ones",
            )


def _rod_lines(rigid: Mapping[str, Line]) -> Iterator[Problem]:
    for name, line in rigid.items():
        for side in SIDES:
            if (reel := reel_key(getattr(line, side))) is not None:
                yield Problem(
                    ("lines", name, side),
                    f"expected an elastic line on a {reel}, found an inextensible one",
                )
        if line.bending is not None:
            yield Problem(
                ("lines", name, "bending"), "expected no bending of an inextensible line, found one"
            )
