"""Where a rigid body is and how it moves: rotations, points of it, inertia in its coordinates.

In one dimension a body has a place alone, q = (x). In a plane q = (place, angle), with positive
angles from the second axis towards the first: about +y where the axes are x and z, bow down for a
bow at +x. In space q = (x, y, z, roll, pitch, yaw), turned by roll about x first, then pitch about
y, then yaw about z (singular at a pitch of 90 degrees). Places in m, angles in rad.

What jax would find by following a body's place and mass is written down here, in products of a few
matrices: 20 s of a body on three lines of 20 segments take 1.2 s so instead of 1.4.
`tests/physics/test_rigid.py` holds it against jax's own.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

__all__ = [
    "PITCH",
    "ROLL",
    "YAW",
    "place_of",
    "point_rate",
    "rigid_mass",
    "rotation",
    "spin",
    "turning_force",
]


ROLL, PITCH, YAW = 3, 4, 5
"""Where the angles of a body in space stand among its coordinates."""

_CROSS = np.zeros((3, 3, 3))  # (a x b)_i = _CROSS_ijk b_j a_k
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _k, _j], _CROSS[_i, _j, _k] = 1.0, -1.0


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
            c * b, c * B * A - C * a, c * B * a + C * A,
            C * b, C * B * A + c * a, C * B * a - c * A,
            -B, b * A, b * a,
        ]
    ).reshape(3, 3)  # fmt: skip


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


def point_rate(
    q: Float[Array, " m"], v: Float[Array, " m"], point: Float[Array, " d"]
) -> tuple[Float[Array, "d m"], Float[Array, " d"], Float[Array, " d"]]:
    """Of a point of a body: J = dr/dq, its velocity J v (m/s), and (dJ/dt) v (m/s2).

    With the angular velocity w and the arm p from the centre of gravity, r' = x' + w x p and
    r'' = x'' + w' x p + w x (w x p).
    """
    d = point.shape[0]
    place, turn = jnp.eye(d, dtype=q.dtype), rotation(q[d:])
    if q.shape[0] == d:
        return place, v, jnp.zeros_like(v)
    if d == 2:
        arm = turn @ point
        matrix = jnp.concatenate([place, _quarter(arm)[:, None]], axis=1)
        return matrix, v[:2] + _quarter(arm) * v[2], -arm * v[2] ** 2
    axes, speed, drift = _turned(q[3:], v[3:])
    # of the arm by each angle, and twice by time but for what the angles' own accelerations do
    slopes = jnp.tensordot(_crosses(axes), turn, (1, 0)) @ point
    once = _crosses(speed)
    twice = (_crosses(drift) + once @ once) @ turn
    return jnp.concatenate([place, slopes], axis=1), v[:3] + slopes @ v[3:], twice @ point


def turning_force(
    q: Float[Array, " m"], v: Float[Array, " m"],
    translation: Float[Array, " d"], inertia: Float[Array, " a"],
) -> Float[Array, " m"]:  # fmt: skip
    """The velocity terms (dM/dt) v - d(v . M v / 2)/dq (N, N m) of the mass matrix M of `rigid_mass`.

    With masses that differ along the body's axes, p = R diag(m) R^T x' is the momentum: it turns with
    the body, w x p - R diag(m) R^T (w x x'), and the moment -p x x' turns the body (M. M. Munk, NACA
    Rep. 184, 1924). Of the rotation I S' (roll', ..) + w x I w is left, in the body's axes, by Euler.
    """
    d = translation.shape[0]
    if q.shape[0] == d:
        return jnp.zeros_like(v)
    turn, speed = rotation(q[d:]), v[:d]
    mass = (turn * translation) @ turn.T
    momentum = mass @ speed
    if d == 2:
        force = v[2] * (_quarter(momentum) - mass @ _quarter(speed))
        return jnp.concatenate([force, jnp.dot(momentum, _quarter(speed))[None]])
    axes, turns, drift = _turned(q[3:], v[3:])
    crosses, whole = _crosses(turns), (turn * inertia) @ turn.T
    force = crosses @ momentum - mass @ (crosses @ speed)
    moment = whole @ drift + crosses @ (whole @ turns) - _crosses(momentum) @ speed
    return jnp.concatenate([force, axes.T @ moment])


def _turned(
    angles: Float[Array, " 3"], rates: Float[Array, " 3"]
) -> tuple[Float[Array, "3 3"], Float[Array, " 3"], Float[Array, " 3"]]:
    """W of the angular velocity w = W (roll', ..) along x, y, z, w (rad/s), and W' (roll', ..) (rad/s2).

    The columns of W are the axes of roll, pitch and yaw, Rz Ry ex, Rz ey and ez: yaw takes the first two
    along, pitch the first, and w' has what that makes of each.
    """
    (_, b, c), (_, B, C) = jnp.cos(angles), jnp.sin(angles)
    one, none = jnp.ones_like(b), jnp.zeros_like(b)
    axes = jnp.stack([c * b, -C, none, C * b, c, none, -B, none, one]).reshape(3, 3)
    by_roll, by_pitch, by_yaw = (axes * rates).T
    crosses = _crosses(by_yaw)
    drift = crosses @ (by_pitch + by_roll) + _crosses(by_pitch) @ by_roll
    return axes, by_roll + by_pitch + by_yaw, drift


def _quarter(vector: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """What a vector of a body in a plane changes by with the angle."""
    return jnp.stack([vector[1], -vector[0]])


def _crosses(a: Float[Array, "3 *n"]) -> Float[Array, "3 3 *n"]:
    """The matrix of a x, for each of several vectors."""
    return jnp.tensordot(jnp.asarray(_CROSS, a.dtype), a, (2, 0))
