"""The parted line as numbers, read from its scene by formulas of its own, for all but the engine.

Nothing here uses the engine's laws: what judges it, and what competes with it, is written anew.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from lumpedcable.exact import inverse_tension
from lumpedcable.scene import Scene
from lumpedcable.scene.ends import HeldForce
from lumpedcable.scene.materials import LinearMaterial, TanhMaterial

Array = NDArray[np.float64]

TWICE_AREA = {"textbook": np.pi, "half": np.pi / 2, "projected": 1.0}


@dataclass(frozen=True)
class Line:
    """A straight line held at one end and pulled at the other, which lets go.

    length L (m), mass m (kg/m), pull T0 (N), break_time (s), drag k (N s2/m2 per metre: the force on
    a metre is -k v|v|); the law is T = p1 tanh(p2 e + p3) + p4 + p5 e (N), a linear one has p1 = 0;
    `cut` says that it cannot push. s runs from the fixed end, v is positive away from it.
    """

    length: float
    mass: float
    pull: float
    break_time: float
    drag: float
    law: tuple[float, float, float, float, float]
    cut: bool

    def tension(self, strain: ArrayLike) -> Array:
        """T(e) in N."""
        p1, p2, p3, p4, p5 = self.law
        e = np.asarray(strain, float)
        T = p1 * np.tanh(p2 * e + p3) + p4 + p5 * e
        return np.maximum(T, 0.0) if self.cut else T

    def slope(self, strain: ArrayLike) -> Array:
        """T'(e) in N, 0 where the line is slack."""
        p1, p2, p3, p4, p5 = self.law
        e = np.asarray(strain, float)
        th = np.tanh(p2 * e + p3)
        rise = p1 * p2 * (1.0 - th * th) + p5
        return np.where(p1 * th + p4 + p5 * e > 0.0, rise, 0.0) if self.cut else rise

    def speed(self, strain: ArrayLike) -> Array:
        """Speed of sound c = sqrt(T'/m) in m/s, per unstretched length."""
        return np.sqrt(self.slope(strain) / self.mass)

    @property
    def inflection(self) -> float:
        """Strain at which the law is steepest, NaN for a linear law."""
        p1, p2, p3, *_ = self.law
        return -p3 / p2 if p1 != 0.0 else np.nan

    def strain(self, tension: float) -> float:
        """The strain that carries a tension (N)."""
        return inverse_tension(self.tension, tension)

    def force(self, t: float) -> float:
        """What still holds the end at t (s), N: T0 cos^2(pi t / (2 break_time))."""
        if t >= self.break_time:
            return 0.0
        return self.pull * np.cos(0.5 * np.pi * t / self.break_time) ** 2

    def fastest(self) -> float:
        """Largest speed of sound (m/s) between slack and the strain before the break."""
        start = self.strain(self.pull)
        peak = self.inflection if 0.0 < self.inflection < start else start
        return float(max(self.speed(start), self.speed(peak)))


def line_of(scene: Scene) -> Line:
    """The numbers of a scene made from parted-line.toml."""
    rope, water = scene.lines["rope"], scene.water
    material, event = scene.materials[rope.material], scene.events["break"]
    assert isinstance(rope.end.held, HeldForce)
    drag = 0.0
    if rope.drag is not None and water is not None:
        area = TWICE_AREA[rope.drag.convention]
        drag = 0.5 * water.density * rope.diameter * area * rope.drag.tangential
    if isinstance(material, TanhMaterial):
        law = (material.p1, material.p2, material.p3, material.p4, material.p5)
    else:
        assert isinstance(material, LinearMaterial)
        law = (0.0, 1.0, 0.0, 0.0, material.EA)
    return Line(
        rope.length, rope.mass, rope.end.held.pretension, event.time, drag, law,
        material.tension_only,
    )  # fmt: skip


def slack_strain(line: Line) -> float:
    """The strain at which the uncut law is zero."""
    uncut = Line(*(line.length, line.mass, line.pull, line.break_time, line.drag, line.law), False)
    return float(brentq(lambda e: float(uncut.tension(e)), -0.05, 0.05, xtol=1e-15))
