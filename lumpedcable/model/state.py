"""The state of a scene, what is accumulated on the way, and what measures see of it."""

from typing import NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

__all__ = ["Seen", "State"]


class State(eqx.Module):
    """Displacements and velocities of every line, and what the past has left behind.

    displacement and velocity: by line, (d, nodes) in m and m/s. work: by line and kind, energies
    (J) accumulated so far, per node, per segment or as scalars (empty where the scene asks for
    none). reaction: by "line.start" or "line.end", the force (d,) in N that a driven or joined end
    carried when it last held (empty where no such end can break). tension: by inextensible line,
    what its segments carry (n,) in N. memory: by line whose material relaxes, how far the dashpots of
    its k branches are stretched (k, n).
    """

    displacement: dict[str, Float[Array, "d nodes"]]
    velocity: dict[str, Float[Array, "d nodes"]]
    work: dict[str, dict[str, Array]]
    reaction: dict[str, Float[Array, " d"]]
    tension: dict[str, Float[Array, " n"]] = eqx.field(default_factory=dict)
    memory: dict[str, Float[Array, "k n"]] = eqx.field(default_factory=dict)


class Seen(NamedTuple):
    """What measures are taken of: displacements (m) and velocities (m/s) by line and body, tensions
    (N), damping included, of the segments of each line and at its two ends, and the bending moments
    (N m) at the nodes of lines that bend, where anybody asks for them."""

    displacement: dict[str, Array]
    velocity: dict[str, Array]
    tension: dict[str, Float[Array, " n"]]
    ends: dict[str, Float[Array, " 2"]]
    moment: dict[str, Float[Array, " nodes"]] = {}  # noqa: RUF012 (a default that nobody changes)
