"""What is known at one instant of one line, and of one that is cut."""

from typing import NamedTuple

from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.line import LineForces
from lumpedcable.physics.waves import Boundary

__all__ = ["Evaluation", "Splice"]


class Evaluation(NamedTuple):
    """Everything known of one line at one instant: its forces, its nodes' inertia, its end forces.

    `ends` are the known forces on the nodes of the line's ends (N), None where there is none; `grip` the
    friction (N) on the nodes in a kick, None where the line has none; `push` (N) what the water pushes
    them with as it accelerates in waves, which is part of `force`; `past` the velocity (m/s) at which a
    winch moves the line's substance past the nodes, of one that drags or rubs; `hastened` (N) the force
    of inertia of substance that a drum accelerates past them, which is part of `force`.
    """

    line: LineForces
    nodes: inertia.Frame
    ends: tuple[Float[Array, " d"] | None, ...]
    boundaries: tuple[Boundary, ...]
    grip: Float[Array, "d nodes"] | None = None
    push: Float[Array, "d nodes"] | None = None
    past: Float[Array, "d nodes"] | None = None
    hastened: Float[Array, "d nodes"] | None = None

    @property
    def force(self) -> Float[Array, "d nodes"]:
        """Net force on each node (N), with the known end forces and without drag."""
        return self.line.force


class Splice(NamedTuple):
    """What bends over the node at which two lines, or the two parts of one, meet, at one instant.

    `forces` are those on the nodes of either (N), by their names, and `shares` of how soft the node is
    (-) those of either. `stored` is the energy that is left (J), and `power` what a break does to it
    (W), at most 0; None where none is to come.
    """

    forces: dict[str, Float[Array, "d nodes"]]
    shares: dict[str, Float[Array, ""]]
    stored: Float[Array, ""]
    power: Float[Array, ""] | None
