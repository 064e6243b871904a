"""How a scene is computed and what is kept: [solver], [statics], [output], [references]."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, ConfigDict, Field

from lumpedcable.scene.part import Name, Part, Problem, Text
from lumpedcable.scene.quantities import (
    Count,
    Fraction,
    PositiveNumber,
    PositiveTime,
    ReferenceNumber,
    fault,
)
from lumpedcable.scene.units import (
    Dimension,
    UnitError,
    format_quantity,
    split_quantity,
    unit_of,
)

MAX_SAMPLES = 10_000_000
"""Largest number of output times of one run."""
ROUNDING = 1e-9  # share of the duration that it may be off a multiple of the output interval

Method = Literal[
    "leapfrog",
    "rk4",
    "euler",
    "heun",
    "midpoint",
    "ralston",
    "bosh3",
    "tsit5",
    "dopri5",
    "dopri8",
    "kvaerno3",
    "kvaerno4",
    "kvaerno5",
]
FIXED: tuple[Method, ...] = ("leapfrog", "rk4", "euler")
"""Methods that have no estimate of their error."""
IMPLICIT: tuple[Method, ...] = ("kvaerno3", "kvaerno4", "kvaerno5")
ADAPTIVE = frozenset(get_args(Method)) - frozenset(FIXED)
FieldQuantity = Literal["position", "velocity", "tension", "strain", "bending_moment", "energy"]
Precision = Literal["float64", "float32"]


class Solver(Part):
    """How time is stepped."""

    CHOSEN: ClassVar[tuple[str, ...]] = ("courant",)

    method: Method = "leapfrog"
    """The engine's own staggered leapfrog or classical Runge-Kutta (rk4), or a method of diffrax."""
    courant: Fraction = 0.9
    """Fixed step over the largest stable step of the model (fixed-step methods). Not given, it is 0.8
    where waves are corrected and 0.75 where they are viscous."""
    step: PositiveTime | None = None
    """Fixed step in s, instead of courant; at most output.every."""
    rtol: PositiveNumber | None = None
    """Relative tolerance (adaptive methods)."""
    atol: PositiveNumber | None = None
    """Absolute tolerance (adaptive methods)."""
    max_steps: Annotated[int, Count(1, 10**12)] | None = None
    """Largest number of steps before a run gives up (adaptive methods)."""
    dtype: Precision = "float64"
    """Floating-point type of the computation."""
    waves: Literal["corrected", "viscous", "plain"] | None = None
    """Treatment of fronts. Absent: corrected where an event breaks a line, else viscous where a law
    is not linear or is tension_only, else plain."""

    @property
    def adaptive(self) -> bool:
        """Whether the method chooses its steps itself."""
        given = self.step is not None or "courant" in self.model_fields_set
        return self.method in ADAPTIVE and not given

    def problems(self) -> Iterator[Problem]:
        """Yield settings that exclude each other."""
        if self.step is not None and "courant" in self.model_fields_set:
            yield Problem(("step",), "expected step or courant, found both")
        if not self.adaptive:
            reasons = {"rtol": "it has no error estimate", "atol": "it has no error estimate",
                       "max_steps": "its steps are fixed"}  # fmt: skip
            for key, reason in reasons.items():
                if key != "max_steps" and self.method in IMPLICIT:
                    continue  # they find their stages to it
                if (value := getattr(self, key)) is not None:
                    message = f'expected no {key} with method = "{self.method}" ({reason})'
                    if self.method not in FIXED:
                        message = f"expected no {key} beside a step or courant that is given"
                    yield Problem((key,), f"{message}, found {value:g}")


class Statics(Part):
    """How the start state is found."""

    tolerance: PositiveNumber = 1e-10
    """Largest residual force relative to the forces of the scene."""
    max_iterations: Annotated[int, Count(1)] = 200
    """Largest number of iterations."""


class Output(Part):
    """What is kept of a run."""

    model_config: ClassVar[ConfigDict] = ConfigDict(
        json_schema_extra={"dependentRequired": {"duration": ["every"], "every": ["duration"]}}
    )

    duration: PositiveTime = 0.0
    """Simulated time in s, a whole number of times every. Without it the scene is at rest: statics
    alone."""
    every: PositiveTime = 0.0
    """Time in s between kept states; needed with duration."""
    fields_every: PositiveTime | None = None
    """Time in s between kept fields, a whole number of times every. Absent: every. Tensions at the ends,
    energies and all else that is one number at a time are kept at every one still."""
    quantities: tuple[FieldQuantity, ...] = get_args(FieldQuantity)
    """Fields that are kept, the bending moments of lines with bending."""
    keep: Literal["fields", "histories", "summaries"] = "fields"
    """How much of a run is kept: everything; tensions at the ends, place and velocity of broken ends
    and energies over time, but no fields; or its numbers alone."""
    statistics: bool = False
    """Whether the summary has the mean and the standard deviation of each measure besides."""
    stop: Text | None = None
    """A rigid body that starts with a velocity: the run ends when its velocity along that one has
    fallen to zero, and what would follow repeats its last state, that of the end of the step in which
    it does; not with a method that chooses its steps. Absent: at `duration`."""
    precision: Precision = "float64"
    """Floating-point type of the kept fields; scalars are always float64."""

    @property
    def static(self) -> bool:
        """Whether the scene stays at rest."""
        return self.duration == 0.0

    @property
    def count(self) -> int:
        """Number of output times after the start; none of a scene at rest."""
        if self.static:
            return 0
        return max(1, math.floor(self.duration / self.every * (1.0 + ROUNDING)))

    @property
    def fields_after(self) -> int:
        """From how many output times to how many there is a field again."""
        return 1 if self.fields_every is None else round(self.fields_every / self.every)

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong between the fields."""
        if (self.every == 0.0) != (self.duration == 0.0):
            absent = "duration" if self.duration == 0.0 else "every"
            yield Problem(
                (absent,), "expected duration and every together, or neither, found one of them"
            )
        elif self.static:
            pass
        elif self.every > self.duration * (1.0 + ROUNDING):
            yield Problem(
                ("every",),
                f"expected at most the duration, {format_quantity(self.duration, 's')}, "
                f"found {format_quantity(self.every, 's')}",
            )
        elif self.duration / self.every > MAX_SAMPLES:
            yield Problem(
                ("every",),
                f"expected at most {MAX_SAMPLES} output times, "
                f"found {self.duration / self.every:.3g}",
            )
        elif self.duration > self.count * self.every * (1.0 + ROUNDING):
            # a run ends at an output time: what comes after the last one would not happen
            near = [format_quantity(n * self.every, "s", 10) for n in (self.count, self.count + 1)]
            yield Problem(
                ("duration",),
                f"expected a whole number of times every, {format_quantity(self.every, 's')}: "
                f"{near[0]} or {near[1]}, found {format_quantity(self.duration, 's', 10)}",
            )
        yield from self._spacing()
        if not self.quantities:
            yield Problem(
                ("quantities",),
                'expected at least one quantity, found none (keep = "histories" keeps no field)',
            )
        for i, quantity in enumerate(self.quantities):
            if quantity in self.quantities[:i]:
                yield Problem(
                    ("quantities",), f'expected each quantity once, found "{quantity}" again'
                )
                break

    def _spacing(self) -> Iterator[Problem]:
        """Yield what is wrong with the time between fields."""
        between, path = self.fields_every, ("fields_every",)
        if between is None:
            return
        found = f"found {format_quantity(between, 's', 10)}"
        if self.static:
            yield Problem(path, f"expected a duration with it, {found} for a scene at rest")
        elif self.keep != "fields":
            yield Problem(
                path, f'expected keep = "fields" with it, {found} with keep = "{self.keep}"'
            )
        elif between > self.duration * (1.0 + ROUNDING):
            most = format_quantity(self.duration, "s")
            yield Problem(path, f"expected at most the duration, {most}, {found}")
        elif self.every > 0.0:
            times = between / self.every
            if abs(times - max(1, round(times))) > ROUNDING * times:
                near = dict.fromkeys(
                    max(1, whole) for whole in (math.floor(times), math.ceil(times))
                )
                each, *told = (format_quantity(n * self.every, "s", 10) for n in (1, *near))
                message = (
                    f"expected a whole number of times every, {each}: {' or '.join(told)}, {found}"
                )
                yield Problem(path, message)


def _one_kind(value: Any) -> Any:
    """Return the values as a list; texts among them must be of one dimension."""
    values = value if isinstance(value, list | tuple | dict) else [value]
    kinds: dict[Dimension, str] = {}
    for item in values:
        with suppress(UnitError):  # told by the item itself
            if isinstance(item, str):
                kinds.setdefault(unit_of(split_quantity(item)[1])[1], item)
    if len(kinds) > 1:
        given = " and ".join(f'"{item}"' for item in kinds.values())
        raise fault(f"expected values of one dimension, found {given}")
    return values


ReferenceValues = Annotated[
    tuple[Annotated[float, ReferenceNumber()], ...], BeforeValidator(_one_kind)
]


class Reference(Part):
    """Numbers from elsewhere, shown beside the results."""

    source: Text
    """Where they come from: paper, section, table."""
    note: Text | None = None
    """What a reader should know about them."""
    values: Annotated[dict[Name, ReferenceValues], Field(min_length=1)]
    """Per result: one SI number per run, in the order of the sweep; nan where there is none."""
