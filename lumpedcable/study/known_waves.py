"""The exact wave that a broken line's is measured by: what is known of it before it breaks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
import numpy as np

from lumpedcable.exact import release_wave
from lumpedcable.model.line import Line
from lumpedcable.model.materials import LAWS
from lumpedcable.model.seams import part_length
from lumpedcable.physics.tension import AbstractTensionLaw
from lumpedcable.results.schema import END_SPEED
from lumpedcable.scene import Scene, Study, TableMaterial
from lumpedcable.solve.observe import ARRIVAL_DROP, Recoil
from lumpedcable.study.account import Account
from lumpedcable.study.begins import source_of
from lumpedcable.study.speeds import allowance

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from lumpedcable.study.part import Part

__all__ = ["curve_of", "exact_wave", "mass_along", "still", "tensions_of"]


def still(
    account: Account, index: int, begins: NDArray[np.float64], every: float
) -> NDArray[np.bool_]:
    """Whether each run was at rest until its end broke, at `begins` (s), as the exact wave has it.

    Its far end has the tension that it had at the start, within 1 %, and nothing has moved with more
    than 1 % of the speed of what comes, 1e-4 of its kinetic energy.
    """
    if not account.complete:
        return begins <= 0.0
    watch, kinetic = account.watches[index], account.largest["kinetic"]
    rest = np.asarray(watch.rest, float)
    kept = np.abs(np.asarray(watch.loaded, float) - rest) <= ARRIVAL_DROP * np.abs(rest)
    before = np.arange(account.count + 1) * every < begins[:, None] * (1.0 - 1e-9)
    most = np.nanmax(np.where(np.isfinite(kinetic), kinetic, 0.0), axis=1)
    quiet = np.all(~before | (kinetic <= 1e-4 * most[:, None]), axis=1)
    return (begins <= 0.0) | (kept & quiet)


def tensions_of(
    study: Study, part: Part, line: str, strain: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Tension (N) of each run's law at its strain."""
    if not any(key.startswith("materials.") for key in study.runs.moved):
        return curve_of(part.structure.scene, line)(strain)
    each = zip(part.runs, strain, strict=True)
    return np.array([curve_of(study.runs[int(r)], line)(np.asarray([e]))[0] for r, e in each])


def curve_of(scene: Scene, line: str) -> Callable[[ArrayLike], NDArray[np.float64]]:
    """The tension law of a line (N over strain) as a plain function, cut at zero where it is."""
    material = scene.materials[scene.lines[line].material]
    curve = material.curve
    if isinstance(material, TableMaterial):
        # the engine's smooth interpolation, not the straight one between the points
        curve = partial(_smooth, LAWS[material.law](material))

    def tension(strain: ArrayLike) -> NDArray[np.float64]:
        value = np.asarray(curve(np.asarray(strain, float)))
        return np.maximum(value, 0.0) if material.tension_only else value

    return tension


@jax.jit
def _smooth(law: AbstractTensionLaw, strain: ArrayLike) -> jax.Array:
    """Tension (N) of a law of the engine at each strain; one program for all of its kind and shape."""
    return law.tension(jnp.asarray(strain))


def mass_along(scene: Scene, line: str) -> float:
    """What waves along a line of the scene move (kg/m): its mass and, with C_t, C_t rho pi d^2/4.

    In double precision, as `Line.mass_along` is not always.
    """
    own = scene.lines[line]
    along = None if own.added_mass is None else own.added_mass.tangential
    return own.mass if along is None else own.mass + along * scene.displaced(line)


def exact_wave(
    scene: Scene, line: Line, recoil: Recoil, k: int, tension: float, begins: float
) -> dict[str, float]:
    """The exact release wave of a straight uniform line from the same tension (N), of run k.

    With the `allowance` for the end speed (m/s), inf where it is no bound.
    """
    if not tension > 0.0 or line.relaxation is not None:
        return {}  # a material that relaxes knows no wave that keeps its form
    source = source_of(scene, recoil.line)
    length = part_length(line, k, recoil.node)
    try:
        wave = release_wave(curve_of(scene, source), mass_along(scene, source), tension0=tension)
    except ValueError:
        return {}  # a law that falls somewhere has no single wave
    return {
        "static_strain": wave.strain0,
        END_SPEED: wave.end_speed,
        "front_arrival": wave.front_arrival(length),
        "allowance": allowance(scene, source, length, wave, begins),
    }
