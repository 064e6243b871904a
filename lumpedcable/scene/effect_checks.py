"""What a scene names that acts on nothing in it: waves, currents, fields of what there is not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from math import pi
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.measures import SEA, ElevationMeasure
from lumpedcable.scene.part import Problem

__all__ = ["effect_problems"]

Parts = Mapping[str, Any]


def effect_problems(
    lines: Parts, bodies: Parts, measures: Parts, others: Parts, named: Set[str]
) -> Iterator[Problem]:
    """Yield what acts on nothing.

    Args:
        lines, bodies, measures: by name, None where one could not be read.
        others: the single parts that could be read, by key.
        named: the keys of all single parts, readable or not.
    """
    yield from _sea(lines, bodies, measures, others, named)
    yield from _unbent(lines, others)
    yield from _undragged(lines, bodies, others)


def _sea(
    lines: Parts, bodies: Parts, measures: Parts, others: Parts, named: Set[str]
) -> Iterator[Problem]:
    """Yield waves that nothing meets, and water that moves in them where there is none."""
    if "sea" not in named:
        return
    sea = others.get("sea")
    # who gives a motion, or waves, of another kind has thought of it
    moves = any(
        getattr(body, key, None) is not None
        for body in bodies.values()
        for key in ("motion", "waves")
    )
    moves |= any(
        m is None or isinstance(m, ElevationMeasure) or getattr(m, "over", None) == SEA
        for m in measures.values()
    )
    if sea is not None and sea.period > 0.0:
        yield from _unanswered(2.0 * pi / sea.period, bodies)
    flow = sea is None or sea.flow is not None
    if not moves and not flow and None not in bodies.values():
        yield Problem(
            ("sea",),
            "expected flow, a body that moves in its waves (motion or waves with rao or response), or a "
            f'measure of them (elevation, height over = "{SEA}"), found none: they act on nothing else',
        )
    if sea is None or sea.flow is None:
        return
    if "water" not in named:
        yield Problem(("sea", "flow"), "expected [water] that moves in waves, found none")
    feels = any(line is None or line.diameter is not None for line in lines.values())
    for body in bodies.values():
        feels |= body is None or (isinstance(body, Body) and body.rigid and body.feels_flow)
    if not feels:
        yield Problem(
            ("sea", "flow"),
            "expected a line with a diameter, or a rigid body with volume or drag, which water that "
            "moves acts on, found none",
        )


def _unanswered(peak: float, bodies: Parts) -> Iterator[Problem]:
    """Yield responses whose table does not reach to the peak (rad/s) of the waves' spectrum."""
    for name, body in bodies.items():
        for key in ("motion", "waves"):
            table = getattr(body, key, None)
            omega = getattr(table, "omega", ())
            if len(omega) > 1 and not omega[0] <= peak <= omega[-1]:
                where = "omega" if getattr(table, "rao", None) is None else "rao"
                yield Problem(
                    ("bodies", name, key, where),
                    f"expected frequencies about {peak:.3g} rad/s, where the waves peak, found "
                    f"{omega[0]:.3g} to {omega[-1]:.3g} rad/s: beyond them there is no response",
                )


def _unbent(lines: Parts, others: Parts) -> Iterator[Problem]:
    """Yield bending moments that are asked for by name where no line bends."""
    output = others.get("output")
    if output is None or "quantities" not in output.model_fields_set:
        return
    bends = any(line is None or line.bending is not None for line in lines.values())
    if "bending_moment" in output.quantities and not bends:
        yield Problem(
            ("output", "quantities", output.quantities.index("bending_moment")),
            "expected a line with bending where bending_moment is kept, found none",
        )


def _undragged(lines: Parts, bodies: Parts, others: Parts) -> Iterator[Problem]:
    """Yield a current that acts on nothing."""
    drags = any(
        x is None
        or getattr(x, "drag", None) is not None
        or (isinstance(x, Body) and x.hull is not None and x.hull.resistance is not None)
        for x in (*lines.values(), *bodies.values())
    )
    for key in ("water", "air"):
        if not drags and key in others and others[key].current is not None:
            yield Problem(
                (key, "current"),
                "expected drag of a line or a body, which a current acts on, found none",
            )
