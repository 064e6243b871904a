"""Damped Newton iteration for the minimum of a strictly convex function of few unknowns.

The statics of a line between two points is such a problem in the force at one end: the
complementary energy is convex, its gradient is where the other end lands minus where it should.
"""

from collections.abc import Callable

import numpy as np

from .law import Array

Gradient = Callable[[Array], tuple[Array, Array]]
"""Unknowns (n,) to gradient (n,) and Hessian (n, n)."""


def convex_minimum(gradient: Gradient, start: Array, size: float, positive: int = 0) -> Array:
    """Return the unknowns at which the gradient vanishes.

    Args:
        gradient: gradient and Hessian of the function.
        start: first guess, shape (n,).
        size: size of the gradient against which its rounding is measured (a length, m).
        positive: this many leading unknowns stay above zero.

    Raises:
        ValueError: if 500 steps do not lead to a gradient of rounding size (1e-9 of `size`).
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        best, best_norm = _descend(gradient, np.asarray(start, float), size, positive)
    if not best_norm < 1e-9 * size:
        raise ValueError(
            f"the end of the line stays {best_norm:.3g} m away from its place; "
            "is the line too short for its stiffness?"
        )
    return best


def _descend(gradient: Gradient, x: Array, size: float, positive: int) -> tuple[Array, float]:
    """Return the best unknowns met and the norm of the gradient there."""
    g, K = gradient(x)
    best, best_norm = x, float(np.linalg.norm(g))
    since = 0  # steps since the gradient was last halved
    for _ in range(500):
        if not np.all(np.isfinite(K)) or not np.max(np.abs(x)) < 1e100:
            break
        step = _newton_step(K, g)
        lead, room = step[:positive], -0.95 * x[:positive]
        short = lead < room
        alpha = float(np.min(room[short] / lead[short], initial=1.0))
        descent = float(g @ step)
        # Along the step the slope g.p of a convex function rises from `descent` < 0; far above
        # zero the step went too far.
        trial, (g, K) = x + alpha * step, gradient(x + alpha * step)
        while float(g @ step) > -0.9 * descent and alpha > 1e-18:
            alpha *= 0.5
            trial, (g, K) = x + alpha * step, gradient(x + alpha * step)
        x = trial
        norm = float(np.linalg.norm(g))
        since += 1
        if norm < best_norm:
            since = since if norm > 0.5 * best_norm else 0
            best, best_norm = x, norm
        if best_norm == 0.0 or (best_norm < 1e-9 * size and since > 3):
            break
    return best, best_norm


def _newton_step(K: Array, g: Array) -> Array:
    """Return -K^-1 g; the scaling keeps unknowns of different size apart from rounding."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(K), np.finfo(float).tiny))
    return -scale * np.linalg.lstsq(K * np.outer(scale, scale), scale * g, rcond=None)[0]
