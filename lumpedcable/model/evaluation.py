"""What is known of one line at one instant."""

from typing import NamedTuple

from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.line import LineForces
from lumpedcable.physics.waves import Boundary

__all__ = ["Evaluation"]


class Evaluation(NamedTuple):
    """Everything known of one line at one instant: its forces, its nodes' inertia, its end forces.

    `ends` are the known forces on the nodes of the line's ends (N), None where there is none; `grip` the
    friction (N) on the nodes in a kick, None where the line has none.
    """

    line: LineForces
    nodes: inertia.Frame
    ends: tuple[Float[Array, " d"] | None, ...]
    boundaries: tuple[Boundary, ...]
    grip: Float[Array, "d nodes"] | None = None

    @property
    def force(self) -> Float[Array, "d nodes"]:
        """Net force on each node (N), with the known end forces and without drag."""
        return self.line.force
