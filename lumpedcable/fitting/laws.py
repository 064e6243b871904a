"""Tension laws before and after a fit, with the band that the parameters' uncertainty leaves them."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.uncertainty import reach_of
from lumpedcable.model.materials import law_of
from lumpedcable.scene import Scene, TableMaterial

__all__ = ["LawBand", "law_bands"]

Array = NDArray[np.float64]
POINTS = 201
MOST_BAND = 1e3  # times the largest tension: wider than that a band says nothing


class LawBand(NamedTuple):
    """A law over strain: tension (N) at the start and found, and the half width of its band (N)."""

    material: str
    experiment: str | None
    strain: Array
    start: Array
    tension: Array
    half: Array
    data: tuple[tuple[str, Array, Array], ...]


def law_bands(fitted: Fitted) -> list[LawBand]:
    """The laws that a fit changed, each with the pointwise band of the fit's confidence.

    The band is the linear one, +- z sqrt(g' cov g) with g the derivatives of the tension by the
    parameters (delta method).
    """
    problem, bands = fitted.problem, []
    owners = {
        (p.key.split(".")[1], p.experiment)
        for p in problem.parameters
        if p.key.startswith("materials.")
    }
    for material, experiment in sorted(owners, key=str):
        scene = _scene(fitted, material, experiment)
        data = tuple(
            (t.name, t.series.x, t.series.values)
            for t in problem.tables
            if t.material == material and experiment in (None, t.name)
        )
        if scene is not None:
            bands.append(_band(fitted, scene, material, experiment, data))
    return bands


def _scene(fitted: Fitted, material: str, experiment: str | None) -> Scene | None:
    """A scene with that material, that of the experiment if there is one."""
    problem = fitted.problem
    users = [(t.name, t.study) for t in problem.tables] + [
        (r.name, r.study) for r in problem.records
    ]
    for name, study in users:
        if experiment in (None, name) and material in study.scene.materials:
            return study.scene
    return None


def _band(fitted: Fitted, scene: Scene, material: str, experiment: str | None, data) -> LawBand:
    problem = fitted.problem
    numbers = scene.numbers()
    keys = [
        (k, p.key)
        for k, p in enumerate(problem.parameters)
        if p.experiment in (None, experiment) and p.key in numbers
        and p.key.startswith(f"materials.{material}.")
    ]  # fmt: skip
    strain = _strains(problem, scene, material, data)

    def tension(values):
        mine = {key: values[i] for i, (_, key) in enumerate(keys)}
        law = scene.with_numbers(mine).materials[material]
        return law_of(law.model_copy(update={"tension_only": False})).tension(jnp.asarray(strain))

    index = [k for k, _ in keys]
    start = np.array([problem.parameters[k].start for k in index])
    found = fitted.values[index]
    slope = np.asarray(jax.jacfwd(tension)(jnp.asarray(found)))
    covariance = fitted.certainty.covariance[np.ix_(index, index)]
    with np.errstate(invalid="ignore"):
        variance = np.einsum("ni,ij,nj->n", slope, covariance, slope)
        reach = reach_of(problem.known_noise, problem.method.confidence, fitted.certainty.free)
        half = reach * np.sqrt(np.maximum(variance, 0.0))
    law = np.asarray(tension(jnp.asarray(found)))
    half = np.where(half < MOST_BAND * np.max(np.abs(law)), half, np.nan)
    before = np.asarray(tension(jnp.asarray(start)))
    return LawBand(material, experiment, strain, before, law, half, data)


def _strains(problem, scene: Scene, material: str, data) -> Array:
    """Strains from 0 to where the data end: that of the largest tension in a record, or of a table."""
    law = scene.materials[material]
    top = law.strain[-1] if isinstance(law, TableMaterial) else law.max_strain
    reached = [float(np.max(x)) for _, x, _ in data]
    pulls = [
        float(np.max(series.values))
        for record in problem.records
        for series in record.series
        if series.unit == "N"
    ]
    if pulls:
        every = np.linspace(0.0, top, 2001)
        with np.errstate(all="ignore"):
            beyond = every[law.curve(every) >= max(pulls)]
        reached.append(float(beyond[0]) if beyond.size else top)
    return np.linspace(0.0, min(1.05 * max(reached, default=top), top), POINTS)
