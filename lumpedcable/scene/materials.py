"""Tension laws as a scene names them: T(strain) with its parameters, damping and range of use.

Strain e is (stretched length - unstretched length) / unstretched length; tension T is in N.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, StrictBool, Tag

from lumpedcable.scene.part import Name, Part, Problem, Text, choose, pick_word, tag
from lumpedcable.scene.quantities import (
    Damping,
    Force,
    NonNegativeForce,
    Number,
    PositiveForce,
    PositiveNumber,
    PositiveTime,
)
from lumpedcable.scene.units import format_quantity

_SAMPLES = 2001  # strains looked at between 0 and max_strain, both included


class Branch(Part):
    """A spring in series with a dashpot, beside the law: q = EA (e - s), ds/dt = (e - s) / time."""

    EA: NonNegativeForce
    """Stiffness in N that it adds to the law's for loads that are fast; 0 is as if it were not there."""
    time: PositiveTime
    """Time in s within which its tension falls to 1/e of itself while the length stays."""


class _Law(Part):
    """What every tension law has."""

    JUDGED: ClassVar[tuple[str, ...]] = ("breaking_strength",)

    tension_only: StrictBool = False
    """T = max(T, 0), and 0 below the strain where T is 0: the line cannot push."""
    damping: Damping | None = None
    """Kelvin-Voigt constant c in N s: T gains c de/dt, with tension_only where it is taut.
    Absent: none."""
    relaxation: dict[Name, Branch] = Field(default_factory=dict)
    """Branches by names of their own, each a spring and a dashpot in series beside the law, which then
    is that of slow loads. Absent: none."""
    max_strain: PositiveNumber = 0.5
    """The law is used for strains from -max_strain to max_strain; it bounds the wave speed. A run that
    stretches a line further ends with status `strain_exceeded`."""
    breaking_strength: PositiveForce | None = None
    """Minimum breaking load in N, which the largest tension is compared with. Absent: none."""

    def __hash__(self) -> int:
        """Of all that it has; a table of branches has no hash of its own."""
        own = (frozenset(v.items()) if isinstance(v, dict) else v for v in self.__dict__.values())
        return hash((type(self), *own))

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return T in N for strains (any shape) of slow loads, without damping, before tension_only."""
        raise NotImplementedError

    def top_strain(self) -> float:
        """Return the largest strain that a pretension may use."""
        return self.max_strain

    def reach(self) -> float:
        """Return the largest tension in N on strains from 0 to :meth:`top_strain`."""
        return _reach(self)  # pyright: ignore[reportArgumentType] (frozen models have a hash)

    def sampled(self) -> np.ndarray:
        """Return the tensions in N at strains evenly from 0 to :meth:`top_strain`."""
        with np.errstate(all="ignore"):
            return self.curve(np.linspace(0.0, self.top_strain(), _SAMPLES))

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where the law never rises, so that no wave could run along the line."""
        tension = self.sampled()
        if not np.all(np.isfinite(tension)):
            yield Problem((), "expected a finite tension on [0, max_strain], found an overflow")
        elif not np.any(np.diff(tension) > 0):
            top = format_quantity(self.top_strain(), "")
            yield Problem(
                (), f"expected a tension that rises with strain, found none on [0, {top}]"
            )


@lru_cache
def _reach(law: _Law) -> float:
    """The reach of a law (N), which all runs of a sweep ask for that differ in other things."""
    return float(np.max(law.sampled()))


class LinearMaterial(_Law):
    """T = EA e."""

    law: Literal["linear"]
    """Hooke's law."""
    EA: PositiveForce
    """Axial stiffness in N: tension per strain."""

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return EA e in N."""
        return self.EA * strain


class TanhMaterial(_Law):
    """T = p1 tanh(p2 e + p3) + p4 + p5 e (Tjavaras 1996, for Bitting's nylon tests)."""

    law: Literal["tanh"]
    """The five-parameter law of synthetic ropes."""
    p1: Force
    """Half the height of the tanh step, in N."""
    p2: Number
    """Steepness of the step, per strain."""
    p3: Number
    """Place of the step: its middle is at e = -p3/p2."""
    p4: Force
    """Tension in the middle of the step, in N."""
    p5: Force
    """Slope of the straight part, in N per strain."""

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return p1 tanh(p2 e + p3) + p4 + p5 e in N."""
        return self.p1 * np.tanh(self.p2 * strain + self.p3) + self.p4 + self.p5 * strain


class PolynomialMaterial(_Law):
    """T = c1 e + c2 e^2 + ... + cn e^n, without a constant term."""

    law: Literal["polynomial"]
    """A polynomial through the origin."""
    coefficients: Annotated[tuple[Force, ...], Field(min_length=1)]
    """c1, c2, ... in N."""

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return the sum of c_k e^k in N, k from 1."""
        total = np.zeros_like(strain)
        for coefficient in reversed(self.coefficients):
            total = (total + coefficient) * strain
        return total


class TableMaterial(_Law):
    """T through measured points, smooth and monotone between them and straight beyond them."""

    FILE: ClassVar[tuple[str, ...]] = ("file", "strain", "tension")

    law: Literal["table"]
    """Points from the scene itself or from a CSV file."""
    strain: tuple[Number, ...] = ()
    """Strains of the points, increasing."""
    tension: tuple[Force, ...] = ()
    """Tensions of the points in N, never falling."""
    file: Text | None = None
    """CSV file with columns strain, tension (N), instead of the two lists."""

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return T in N on straight lines between the points: enough for its range."""
        return np.interp(strain, self.strain, self.tension)

    def top_strain(self) -> float:
        """Return the smaller of max_strain and the last strain of the table."""
        return min(self.max_strain, self.strain[-1])

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the points."""
        told = list(self._wrong_points())
        yield from told
        if not told:
            yield from super().problems()

    def _wrong_points(self) -> Iterator[Problem]:
        at = (lambda key: ("file",)) if self.file is not None else (lambda key: (key,))
        if len(self.strain) < 2:
            found_points = f"{len(self.strain)}" if self.strain else "none"
            yield Problem(
                at("strain"),
                f"expected at least 2 points (lists strain and tension, or file), "
                f"found {found_points}",
            )
        elif len(self.tension) != len(self.strain):
            yield Problem(
                at("tension"),
                f"expected {len(self.strain)} values, one per strain, found {len(self.tension)}",
            )
        else:
            for i in range(1, len(self.strain)):
                if self.strain[i] <= self.strain[i - 1]:
                    yield Problem(
                        at("strain"),
                        f"expected strains that increase, found {self.strain[i]:g} "
                        f"after {self.strain[i - 1]:g}",
                    )
                    return
                if self.tension[i] < self.tension[i - 1]:
                    yield Problem(
                        at("tension"),
                        "expected tensions that never fall, found "
                        f"{format_quantity(self.tension[i], 'N')} "
                        f"after {format_quantity(self.tension[i - 1], 'N')}",
                    )
                    return
            if self.strain[-1] <= 0:
                yield Problem(
                    at("strain"), f"expected a last strain above 0, found {self.strain[-1]:g}"
                )


class InextensibleMaterial(_Law):
    """Segments that keep their length: rods, whose tension follows from the motion."""

    law: Literal["inextensible"]
    """No stretch, or next to none."""
    EA: PositiveForce | None = None
    """Axial stiffness in N, by which rods give way all the same, at any step; what stretches and shrinks
    faster than some ten steps a period is damped. Absent: they do not."""

    def curve(self, strain: np.ndarray) -> np.ndarray:
        """Return the strain itself: any law that rises."""
        return strain

    def reach(self) -> float:
        """Return infinity: it carries any tension."""
        return float("inf")

    def problems(self) -> Iterator[Problem]:
        """Yield the keys of elastic laws."""
        for key in ("damping", "relaxation", "max_strain", "tension_only"):
            if key in self.model_fields_set and getattr(self, key) not in (None, False, {}):
                yield Problem((key,), f"expected no {key} of an inextensible material, found one")


LAWS: dict[str, type[_Law]] = {
    "linear": LinearMaterial,
    "tanh": TanhMaterial,
    "polynomial": PolynomialMaterial,
    "table": TableMaterial,
    "inextensible": InextensibleMaterial,
}
"""The one place where the word in ``law = "..."`` becomes a class."""


def _pick(value: Any) -> str:
    return pick_word(value, "law", LAWS)


Material = Annotated[
    Annotated[LinearMaterial, Tag(tag("linear"))]
    | Annotated[TanhMaterial, Tag(tag("tanh"))]
    | Annotated[PolynomialMaterial, Tag(tag("polynomial"))]
    | Annotated[TableMaterial, Tag(tag("table"))]
    | Annotated[InextensibleMaterial, Tag(tag("inextensible"))],
    *choose(_pick, "a table with law and its parameters"),
]
"""A tension law; ``law`` says which."""
