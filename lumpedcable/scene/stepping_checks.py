"""What inextensible lines, bodies with friction and a stop ask of the solver and the rest of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import WinchEnd
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import SIDES, Problem, did_you_mean
from lumpedcable.scene.run import Output, Solver

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
    solver, output = others.get("solver", Solver()), others.get("output")
    if isinstance(output, Output) and output.stop is not None:
        moving = [
            n for n, b in bodies.items() if b is None or any(getattr(b, "velocity", None) or ())
        ]
        if output.stop not in moving:
            told = did_you_mean(output.stop, moving) or f"; known: {', '.join(moving) or 'none'}"
            yield Problem(
                ("output", "stop"),
                f'expected a body that starts with a velocity, found "{output.stop}"{told}',
            )
    if not isinstance(solver, Solver) or None in lines.values():
        return
    seabed = others.get("seabed")
    if getattr(seabed, "friction", None) is not None and solver.method != "leapfrog":
        yield Problem(
            ("seabed", "friction"),
            f'expected solver.method = "leapfrog" where the bed has friction, found "{solver.method}"',
        )
    if getattr(seabed, "profile", None) is not None:
        for name, body in bodies.items():
            if isinstance(body, Body) and body.friction is not None:
                yield Problem(
                    ("bodies", name, "friction"),
                    "expected a flat seabed where a body has friction, found one with a profile",
                )
    laws = {
        name: getattr(materials.get(line.material), "law", None)
        for name, line in lines.items()
        if line is not None
    }
    rigid = [name for name, law in laws.items() if law == "inextensible"]
    if not rigid:
        for name, body in bodies.items():
            if isinstance(body, Body) and body.friction is not None and solver.method != "leapfrog":
                yield Problem(
                    ("bodies", name, "friction"),
                    'expected solver.method = "leapfrog" where a body has friction, found '
                    f'"{solver.method}"',
                )
        return
    for name, law in laws.items():
        if law not in ("inextensible", None):
            yield Problem(
                ("lines", name, "material"),
                f'expected an inextensible material, as of "{rigid[0]}", found law = "{law}"',
            )
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
    for name in events:
        yield Problem(("events", name), "expected no event where lines are inextensible, found one")
    for name, body in bodies.items():
        if getattr(body, "on", None) is not None:
            yield Problem(
                ("bodies", name, "on"),
                "expected elastic lines under a trolley, found inextensible ones",
            )
    for name in rigid:
        line = lines[name]
        for side in SIDES:
            if line is not None and isinstance(getattr(line, side), WinchEnd):
                yield Problem(
                    ("lines", name, side),
                    "expected an elastic line on a winch, found an inextensible one",
                )
        if line is not None and line.bending is not None:
            yield Problem(
                ("lines", name, "bending"), "expected no bending of an inextensible line, found one"
            )
