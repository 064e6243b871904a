"""Forces on the nodes of a line: those of its shape, which store energy, and those that resist."""

import abc
from collections.abc import Iterable
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from lumpedcable.physics.place import framed, framed_differences, place_at_end

__all__ = ["AbstractLoad", "AbstractResistance", "Shape", "between_nodes"]


class Shape(NamedTuple):
    """A line's geometry, worked out once per evaluation; n segments, n + 1 nodes, d dimensions.

    position (d, n+1) m, tangent (d, n), strain (n,), length (n,) m, and the unstretched lengths of
    segments (n,) or (1,) and nodes (n+1,) m.
    """

    position: Float[Array, "d nodes"]
    tangent: Float[Array, "d segments"]
    strain: Float[Array, " segments"]
    length: Float[Array, " segments"]
    segment_length: Float[Array, "..."]
    node_length: Float[Array, " nodes"]


class AbstractLoad(eqx.Module):
    """A conservative load on a line: its force, its energy, its share in the step bound."""

    energy_name: ClassVar[str]  # the name of the dataset that this load's energy is added to

    @abc.abstractmethod
    def force(self, shape: Shape) -> Float[Array, "d nodes"]:
        """Force on each node (N)."""

    @abc.abstractmethod
    def energy(self, shape: Shape) -> Float[Array, ""]:
        """Potential energy (J), up to a constant."""

    @abc.abstractmethod
    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """Upper bound of omega^2 (1/s2) that the load alone gives a node of the line."""


class AbstractResistance(eqx.Module):
    """A force against the motion of a line: its force, its share in the step bound.

    The power -f . v that it takes is booked as the work `work_name`, a key of `model.energy.WORKS`.
    """

    work_name: ClassVar[str]

    @abc.abstractmethod
    def force(self, shape: Shape, velocity: Float[Array, "d nodes"]) -> Float[Array, "d nodes"]:
        """Force on each node (N) at its velocity (m/s), zero at rest."""

    @abc.abstractmethod
    def rate(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """Upper bound of the rate (1/s) at which it damps a node: the largest -df/dv over mass."""


def between_nodes(
    segment_force: Float[Array, "d n"],
    ends: tuple[Float[Array, " d"] | None, Float[Array, " d"] | None] = (None, None),
    into: Float[Array, "d n+2"] | None = None,
    more: Iterable[tuple[Int[Array, ""], Float[Array, " d"]]] = (),
) -> tuple[Float[Array, "d nodes"], Float[Array, "d n+2"]]:
    """Net force on nodes (N) from forces carried by segments: + on the start node, - on the end.

    `ends` are forces (N) on the first and the last node besides; `more` says what some segments carry
    instead. Also returned: the forces of the segments framed by those of the ends, written over `into`
    if that is given.
    """
    none = jnp.zeros_like(segment_force[:, :1])
    start = none if ends[0] is None else -ends[0][:, None]
    end = none if ends[1] is None else ends[1][:, None]
    carried, given = framed(start, segment_force, end, into), False
    for segment, force in more:
        carried, given = place_at_end(carried, segment + 1, force), True
    if into is None and not given:
        return framed_differences(start, segment_force, end), carried
    return carried[:, 1:] - carried[:, :-1], carried
