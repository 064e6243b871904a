"""Where a rigid body is: rotations, points of it, and inertia in its generalised coordinates.

In one dimension a body has a place alone, q = (x). In a plane q = (place, angle), with positive
angles from the second axis towards the first: about +y where the axes are x and z, bow down for a
bow at +x. In space q = (x, y, z, roll, pitch, yaw), turned by roll about x first, then pitch about
y, then yaw about z (singular at a pitch of 90 degrees). Places in m, angles in rad.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["PITCH", "ROLL", "YAW", "place_of", "rigid_mass", "rotation", "spin"]


ROLL, PITCH, YAW = 3, 4, 5
"""Where the angles of a body in space stand among its coordinates."""


def rotation(angles: Float[Array, " a"]) -> Float[Array, "d d"]:
    """The matrix that takes vectors fixed to the body into the scene's coordinates.

    In space Rz(yaw) Ry(pitch) Rx(roll) of angles (rad).
    """
    if angles.shape[0] == 0:
        return jnp.eye(1, dtype=angles.dtype)
    cosines, sines = jnp.cos(angles), jnp.sin(angles)
    if angles.shape[0] == 1:
        (a,), (A,) = cosines, sines
        return jnp.stack([jnp.stack([a, A]), jnp.stack([-A, a])])
    (a, b, c), (A, B, C) = cosines, sines  # of roll, pitch and yaw
    return jnp.stack(
        [
            jnp.stack([c * b, c * B * A - C * a, c * B * a + C * A]),
            jnp.stack([C * b, C * B * A + c * a, C * B * a - c * A]),
            jnp.stack([-B, b * A, b * a]),
        ]
    )


def place_of(q: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
    """Where a point of the body is (m); `point` (m) counts from its centre of gravity, in its axes."""
    d = point.shape[0]
    return q[:d] + rotation(q[d:]) @ point


def rigid_mass(
    q: Float[Array, " m"], translation: Float[Array, " d"], inertia: Float[Array, " a"]
) -> Float[Array, "m m"]:
    """Mass matrix in the coordinates q, from masses (kg) and inertias (kg m2) along the body's axes.

    T = (sum m_i u_i^2 + sum I_i w_i^2) / 2 with u the velocity of the centre of gravity and w the
    angular velocity, both in the body's axes; q' . M q' = 2 T.
    """
    d = translation.shape[0]
    turn = rotation(q[d:])
    size = q.shape[0]
    mass = jnp.pad((turn * translation) @ turn.T, (0, size - d))
    if inertia.shape[0] == 0:
        return mass
    turning = spin(q[3:]) if inertia.shape[0] == 3 else jnp.eye(1, dtype=q.dtype)
    return mass + jnp.pad(turning.T @ (inertia[:, None] * turning), (d, 0))


def spin(angles: Float[Array, " 3"]) -> Float[Array, "3 3"]:
    """w = S (roll', pitch', yaw') in the body's axes."""
    c, s = jnp.cos(angles), jnp.sin(angles)
    one, none = jnp.ones_like(c[0]), jnp.zeros_like(c[0])
    return jnp.stack([one, none, -s[1], none, c[0], s[0] * c[1], none, -s[0], c[0] * c[1]]).reshape(
        3, 3
    )
