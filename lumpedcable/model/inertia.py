"""Newton's second law at a line's nodes, with mass and drag that differ along and across the line.

Drag is quadratic and stiff on a light line, so a step of leapfrog takes it at the middle of the
step, where it has a closed form: no extra cost, second order, stable at any drag.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from lumpedcable.model.line import Line, node_tangent
from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import Shape
from lumpedcable.physics.vectors import dot, size

__all__ = [
    "Frame",
    "acceleration",
    "drag_force",
    "end_drag",
    "end_matrices",
    "frame",
    "in_waves",
    "kick",
    "kinetic_energy",
    "wave_push",
]


class Frame(NamedTuple):
    """Inertia and resistance of each node along (t) and across (n) the line.

    tangent (d, nodes) or None where the two need not be told apart; masses (kg) and drag factors
    (N s2/m2), shape (nodes,), None without drag; the fluid's velocity (d, nodes) in m/s or None.
    """

    tangent: Float[Array, "d nodes"] | None
    mass_t: Float[Array, " nodes"]
    mass_n: Float[Array, " nodes"]
    drag_t: Float[Array, " nodes"] | None
    drag_n: Float[Array, " nodes"] | None
    flow: Float[Array, "d nodes"] | None

    def split(self, vector: Float[Array, "d nodes"]):
        """The part of a nodal vector along the line (nodes,) and the rest (d, nodes)."""
        assert self.tangent is not None
        along = dot(vector, self.tangent)
        return along, vector - along * self.tangent


def frame(
    line: Line, shape: Shape, height: Float[Array, " nodes"] | None,
    wet: Float[Array, " nodes"] | None = None,
) -> Frame:  # fmt: skip
    """The frame of every node; `height` (m) is where a current is looked up.

    `wet` is how long each node is under water (m), where that is not as in water at rest.
    """
    wet = line.wet(shape) if wet is None else wet
    dry = line.mass * line.node_length
    if line.seam is not None:
        # what does not move has some mass, since it is divided by
        dry = dry + line.seam.hole(line.segments + 1)
    mass_t = mass_n = dry
    if line.added_mass is not None:
        mass_n = dry + line.added_mass.normal * wet
        if line.added_mass.tangential is not None:
            mass_t = dry + line.added_mass.tangential * wet
    drag_t = drag_n = flow = None
    if line.drag is not None:
        drag_t = line.drag.tangential * wet
        drag_n = line.drag.normal * wet
        if line.current is not None and height is not None:
            flow = line.current.velocity(height)
    both = line.dimensions > 1 and (line.drag is not None or line.added_mass is not None)
    tangent = node_tangent(shape.tangent) if both else None
    return Frame(tangent, mass_t, mass_n, drag_t, drag_n, flow)


def wave_push(
    line: Line, nodes: Frame, acceleration: Float[Array, "d nodes"], wet: Float[Array, " nodes"]
) -> Float[Array, "d nodes"]:
    """What water that accelerates by a (m/s2) pushes nodes with (N): rho A a l + m_n a_n + m_t a_t.

    l is how long each node is under water, `wet` (m).

    The first part is that of the pressure in the undisturbed wave, as buoyancy is that of the water
    at rest; the others are the added masses (kg), across and along (J. R. Morison et al., Petroleum
    Transactions AIME 189 (1950), 149-154; DNV-RP-C205, section 6.2.2).
    """
    assert line.displaced is not None
    push = line.displaced * wet * acceleration
    if line.added_mass is None:
        return push
    if nodes.tangent is None:
        along = line.added_mass.tangential
        return push if along is None else push + along * wet * acceleration
    along, across = nodes.split(acceleration)
    push = push + line.added_mass.normal * wet * across
    if line.added_mass.tangential is None:
        return push
    return push + line.added_mass.tangential * wet * along * nodes.tangent


def in_waves(nodes: Frame, water: Float[Array, "d nodes"]) -> Frame:
    """The nodes in water that moves so (m/s) besides any current; as they are where nothing drags."""
    if nodes.drag_t is None:
        return nodes
    return nodes._replace(flow=water if nodes.flow is None else nodes.flow + water)


def drag_force(nodes: Frame, velocity: Float[Array, "d nodes"]) -> Float[Array, "d nodes"] | None:
    """-k_t |v_t| v_t - k_n |v_n| v_n (N) with v relative to the fluid; None without drag."""
    if nodes.drag_t is None or nodes.drag_n is None:
        return None
    v = velocity if nodes.flow is None else velocity - nodes.flow
    if nodes.tangent is None:
        return -nodes.drag_t * jnp.abs(v) * v
    along, across = nodes.split(v)
    return (
        -nodes.drag_t * jnp.abs(along) * along * nodes.tangent
        - nodes.drag_n * size(across) * across
    )


def acceleration(
    nodes: Frame, force: Float[Array, "d nodes"], velocity: Float[Array, "d nodes"]
) -> Float[Array, "d nodes"]:
    """M^-1 (F + drag) (m/s2)."""
    drag = drag_force(nodes, velocity)
    total = force if drag is None else force + drag
    if nodes.tangent is None:
        return total / nodes.mass_t
    along, across = nodes.split(total)
    return along / nodes.mass_t * nodes.tangent + across / nodes.mass_n


def kick(
    nodes: Frame,
    force: Float[Array, "d nodes"],
    before: Float[Array, "d nodes"],
    dt: Float[Array, ""],
) -> tuple[Float[Array, "d nodes"], Float[Array, "d nodes"]]:
    """Velocities at the middle and at the end of a kick of length dt (s) from `before` (m/s).

    M (v+ - v-) / dt = F - k |v| v with v = (v+ + v-) / 2, along and across apart. With
    a = 2 M / dt and b = F + a v-, the root is v = 2 b / (a + sqrt(a^2 + 4 k |b|)), v+ = 2 v - v-.
    A current shifts v by the fluid's velocity.
    """
    if nodes.drag_t is None or nodes.drag_n is None:
        gain = acceleration(nodes, force, before) * dt
        return before + 0.5 * gain, before + gain
    start = before if nodes.flow is None else before - nodes.flow
    a_t = 2.0 * nodes.mass_t / dt
    if nodes.tangent is None:
        b = force + a_t * start
        middle = _root(a_t, b, nodes.drag_t)
    else:
        a_n = 2.0 * nodes.mass_n / dt
        force_t, force_n = nodes.split(force)
        start_t, start_n = nodes.split(start)
        b_t = force_t + a_t * start_t
        b_n = force_n + a_n * start_n
        v_t = _root(a_t, b_t, nodes.drag_t)
        v_n = 2.0 * b_n / (a_n + jnp.sqrt(a_n**2 + 4.0 * nodes.drag_n * size(b_n)))
        middle = v_t * nodes.tangent + v_n
    if nodes.flow is not None:
        middle = middle + nodes.flow
    return middle, 2.0 * middle - before


@jax.custom_jvp
def _root(a: Float[Array, "..."], b: Float[Array, "..."], k: Float[Array, "..."]):
    """The v (m/s) of a v + k |v| v = b, with a in kg/s, b in N, k in kg/m; a and k are not below 0."""
    return 2.0 * b / (a + jnp.sqrt(a**2 + 4.0 * k * jnp.abs(b)))


@_root.defjvp
def _root_jvp(values, tangents):
    # (a + 2 k |v|) dv = db - v da - |v| v dk, with less to work out than the root's own derivative
    a, b, k = values
    v = _root(a, b, k)
    speed = jnp.abs(v)
    da, db, dk = tangents
    return v, (db - v * (da + speed * dk)) / (a + 2.0 * k * speed)


def kinetic_energy(nodes: Frame, velocity: Float[Array, "d nodes"]) -> Float[Array, ""]:
    """v . M v / 2 summed over the nodes, the added mass included (J)."""
    if nodes.tangent is None:
        return 0.5 * jnp.sum(nodes.mass_t * velocity**2)
    along, across = nodes.split(velocity)
    return 0.5 * (jnp.sum(nodes.mass_t * along**2) + jnp.sum(nodes.mass_n * across**2))


def end_matrices(nodes: Frame, node: int | Int[Array, ""], velocity: Float[Array, " d"]):
    """Mass matrix (kg), linearised drag k |v| (N s/m), both (d, d), and flow (m/s) of an end node."""
    d = velocity.shape[0]
    eye = jnp.eye(d, dtype=velocity.dtype)
    flow = jnp.zeros_like(velocity) if nodes.flow is None else pick(nodes.flow, node)
    if nodes.tangent is None:
        along, across = eye, jnp.zeros_like(eye)
    else:
        t = pick(nodes.tangent, node)
        along = jnp.outer(t, t)
        across = eye - along
    mass = pick(nodes.mass_t, node) * along + pick(nodes.mass_n, node) * across
    if nodes.drag_t is None or nodes.drag_n is None:
        return mass, jnp.zeros_like(mass), flow
    relative = velocity - flow
    v_t, v_n = along @ relative, across @ relative
    drag_t, drag_n = pick(nodes.drag_t, node), pick(nodes.drag_n, node)
    drag = drag_t * size(v_t) * along + drag_n * size(v_n) * across
    return mass, drag, flow


def end_drag(
    nodes: Frame, node: int | Int[Array, ""], velocity: Float[Array, " d"]
) -> Float[Array, " d"] | None:
    """What `drag_force` is on an end node (N), worked out there alone; None without drag."""
    if nodes.drag_t is None or nodes.drag_n is None:
        return None
    _, drag, flow = end_matrices(nodes, node, velocity)
    return drag @ (flow - velocity)
