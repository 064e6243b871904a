"""A scene at rest, again and again with other numbers: what a page with sliders asks for."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from numpy.typing import NDArray

from lumpedcable.model.bodies import RigidBody
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import layout_of, make_layout
from lumpedcable.model.numbers import number
from lumpedcable.model.riders import Rider
from lumpedcable.scene import Scene, Study
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.targets import rest_of
from lumpedcable.status import ADVICE, MEANING, Status
from lumpedcable.study.compiled import Structure
from lumpedcable.study.fields import body_fields
from lumpedcable.study.kept import program
from lumpedcable.study.rest import first_pull

__all__ = ["AtRest", "Resting", "RestingBody", "RestingLine", "UnrestError"]


class UnrestError(ValueError):
    """A scene has no equilibrium with some numbers, or none was found; the message says why."""


class RestingLine(NamedTuple):
    """A line at rest.

    Attributes:
        position: places of its nodes (m), shape (node, 3).
        tension: of its segments (N), shape (segment,).
        strain: of its segments (-), shape (segment,).
        ends: tension at its start and its end (N), shape (2,).
        pull: what its first segment pulls its start with (N), shear included, shape (3,).
    """

    position: NDArray[np.float64]
    tension: NDArray[np.float64]
    strain: NDArray[np.float64]
    ends: NDArray[np.float64]
    pull: NDArray[np.float64]


class RestingBody(NamedTuple):
    """A body at rest: its place (m) and its roll, pitch and yaw (rad), each (3,)."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]


class AtRest(NamedTuple):
    """A scene at rest: its lines with nodes and its bodies, by name."""

    lines: dict[str, RestingLine]
    bodies: dict[str, RestingBody]


class _Found(NamedTuple):
    lines: dict[str, tuple[Array, ...]]
    bodies: dict[str, Array]
    converged: Bool[Array, ""]
    imbalance: Float[Array, ""]


@partial(program, static=("structure",))
def _at_rest(
    structure: Structure,
    axes: Float[Array, "3 d"],
    origin: Float[Array, " 3"],
    numbers: Mapping[str, Float[Array, ""]],
) -> _Found:
    """Static equilibrium of one scene; keyed by structure alone."""
    scene = structure.scene.with_numbers(numbers)
    found = rest_of(scene, structure.layout, Coordinates(axes, origin))  # type: ignore[arg-type]
    lines = {}
    for name, line in found.model.lines.items():
        shape = line.shape()
        tension = line.law.tension(shape.strain)
        ends = jnp.stack([tension_at(line, node, found.model, name) for node in (0, -1)])
        lines[name] = (shape.position, first_pull(line), tension, shape.strain, ends)
    d = axes.shape[1]
    bodies = {}
    for name, body in found.model.bodies.items():
        if isinstance(body, RigidBody):
            bodies[name] = body.reference
        elif isinstance(body, Rider):  # it stays upright
            bodies[name] = jnp.pad(body.reference[:d], (0, d * (d - 1) // 2))
    return _Found(lines, bodies, found.converged, found.imbalance)


class Resting:
    """The static equilibrium of a scene as a function of its numbers; compiled once."""

    def __init__(self, study: Study, run: int = 0) -> None:
        """Take run number `run` of a study.

        Raises:
            SceneError: the scene cannot be laid out.
        """
        self.scene: Scene = study.runs[run]
        self._skeleton = self.scene.skeleton()
        layout_of(study, self.scene)  # told with the line of the file

    def solve(self, numbers: Mapping[str, float]) -> AtRest:
        """The lines and bodies at rest, by name: a function of these numbers, whatever was asked before.

        Lengths that targets choose are looked for from the file's first guesses each time. From those
        chosen last it would take half as long, but what is found could be another root.

        Args:
            numbers: by path, as in `Scene.numbers`; those left out are the scene's.

        Raises:
            UnrestError: there is no equilibrium, or none was found; the message says so.
        """
        asked = {key: float(value) for key, value in numbers.items()}
        found = self._at_rest(asked)
        if found is None:
            status = Status.STATICS_NOT_CONVERGED
            raise UnrestError(f"{MEANING[status]}: {ADVICE[status]}")
        return found

    def _at_rest(self, numbers: Mapping[str, float]) -> AtRest | None:
        """The scene with these numbers, None where no equilibrium was found."""
        # floats, always: another type would be another program
        every = {**self.scene.numbers(), **numbers}
        scene = self.scene.with_numbers(every)
        try:
            # where a line that breaks is cut goes by its length
            layout = make_layout(scene)
            coordinates = coordinates_of([scene])
        except ValueError as error:
            raise UnrestError(f"no shape for these numbers: {error}") from error
        found = _at_rest(
            Structure(self._skeleton, layout, self.scene),
            jnp.asarray(coordinates.axes),
            jnp.asarray(coordinates.origin),
            {key: number(value) for key, value in every.items()},
        )
        if not bool(found.converged):
            return None
        lines = {}
        for name, (q, pull, *rest) in found.lines.items():
            place = coordinates.expand(np.asarray(q), axis=0, place=True).T
            tension, strain, ends = map(np.asarray, rest)
            pulls = coordinates.expand(np.asarray(pull), axis=0)
            lines[name] = RestingLine(place, tension, strain, ends, pulls)
        bodies = {}
        for name, q in found.bodies.items():
            values = np.asarray(q)[None, None]
            fields = body_fields(coordinates, values, np.zeros_like(values))
            bodies[name] = RestingBody(fields["position"][0, 0], fields["attitude"][0, 0])
        return AtRest(lines, bodies)
