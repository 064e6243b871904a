"""Finding the parameters: Levenberg-Marquardt, BFGS and L-BFGS of optimistix, each one program."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.fit.arrays import Arrays, Spec
from lumpedcable.fit.residual import failed_runs, penalised, residual, value_and_jacobian

__all__ = ["Found", "search", "searches"]

REVERSE_FROM = 9
"""Free numbers from which a gradient is taken in reverse."""


class Found(NamedTuple):
    """Where a search ended: parameters z, half the sum of squares there, and what it took.

    `steps` are evaluations of the model, each with its derivatives; in `failed` runs of the scene
    the run failed (-1: not counted).
    """

    z: Float[Array, " p"]
    loss: Float[Array, ""]
    steps: Int[Array, ""]
    failed: Int[Array, ""]
    converged: Bool[Array, ""]


class _Counted(eqx.Module):
    inner: Any
    failed: Int[Array, ""]


class TrustRegion(optx.AbstractSearch):
    """The classical trust region, that counts failed runs and knows when rounding is all that is left.

    A step whose predicted gain is below the rounding of the loss is taken rather than refused for
    ever, so that the search ends.
    """

    runs: int
    inner: optx.ClassicalTrustRegion = optx.ClassicalTrustRegion(
        high_cutoff=0.75, low_cutoff=1e-3, high_constant=6.0, low_constant=0.2
    )

    def init(self, y, f_info_struct):
        """No run has failed."""
        return _Counted(self.inner.init(y, f_info_struct), jnp.zeros((), int))

    def step(self, first_step, y, y_eval, f_info, f_eval_info, state):
        """Accept or refuse a step, as the inner search says unless nothing is left to gain."""
        size, accept, result, inner = self.inner.step(
            first_step, y, y_eval, f_info, f_eval_info, state.inner
        )
        now, after = f_info.as_min(), f_eval_info.as_min()
        gain = -self.inner.predict_reduction(y_eval - y, f_info)
        floor = 1e-13 * now + 1e-17
        settled = ~first_step & (gain <= floor) & (after <= now + 10.0 * floor)
        size = jnp.where(settled & ~accept, state.inner.step_size, size)
        inner = eqx.tree_at(lambda s: s.step_size, inner, size)
        failed = state.failed + failed_runs(self.runs, f_eval_info.residual)
        return size, accept | settled, result, _Counted(inner, failed)


class Marquardt(optx.AbstractGaussNewton):
    """Levenberg-Marquardt with `TrustRegion`."""

    rtol: float
    atol: float
    search: TrustRegion
    norm: Any = optx.max_norm
    descent: optx.DampedNewtonDescent = optx.DampedNewtonDescent()
    verbose: Any = eqx.field(default=lambda **kwargs: None, static=True)


@partial(jax.jit, static_argnames=("spec", "solver", "tolerance", "max_steps"))
def search(
    spec: Spec, arrays: Arrays, z: Float[Array, " p"], solver: str, tolerance: float, max_steps: int
) -> Found:
    """One search from z."""
    return _search(spec, arrays, z, solver, tolerance, max_steps)


@partial(jax.jit, static_argnames=("spec", "solver", "tolerance", "max_steps", "axes"))
def searches(
    spec: Spec, arrays: Arrays, z: Float[Array, "lanes p"], solver: str, tolerance: float,
    max_steps: int, axes: Any = None,
) -> Found:  # fmt: skip
    """Many searches at once, one a lane; `axes` tells which arrays differ between lanes (vmap)."""

    def one(arrays, z):
        return _search(spec, arrays, z, solver, tolerance, max_steps)

    return jax.vmap(one, in_axes=(axes, 0))(arrays, z)


def _search(spec, arrays, z, solver: str, tolerance: float, max_steps: int) -> Found:
    z = jnp.asarray(z, float)
    runs = sum(group.every.shape[0] for group in arrays.groups)
    if solver == "levenberg-marquardt":
        solution = optx.least_squares(
            lambda z, a: residual(spec, a, z), Marquardt(tolerance, tolerance, TrustRegion(runs)),
            z, arrays, max_steps=max_steps, throw=False,
        )  # fmt: skip
        half = 0.5 * jnp.sum(solution.state.f_info.residual ** 2)
        failed = solution.state.search_state.failed
    else:
        kind = {"bfgs": optx.BFGS, "l-bfgs": optx.LBFGS}[solver]
        solution = optx.minimise(
            lambda z, a: loss(spec, a, z), kind(tolerance, tolerance), z, arrays,
            max_steps=max_steps, throw=False,
        )  # fmt: skip
        half = solution.state.f_info.f
        failed = jnp.full((), -1)
    steps = solution.stats["num_steps"]
    return Found(
        solution.value, half, steps, failed, solution.result == optx.RESULTS.successful
    )


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def loss(spec: Spec, arrays: Arrays, z: Float[Array, " p"]) -> Float[Array, ""]:
    """Half the sum of squares of `penalised`."""
    return 0.5 * jnp.sum(penalised(spec, arrays, z) ** 2)


@loss.defjvp
def _loss_jvp(spec, primals, tangents):
    arrays, z = primals
    value, slope = value_and_gradient(spec, arrays, z)
    return value, slope @ tangents[1]


def value_and_gradient(spec: Spec, arrays: Arrays, z: Float[Array, " p"]):
    """`loss` and its gradient: forward for few parameters, in reverse where steps are fixed."""
    if all(group.steps is not None for group in spec.groups) and z.size >= REVERSE_FROM:

        def half(z):
            return 0.5 * jnp.sum(penalised(spec, arrays, z) ** 2)

        value, slope = jax.value_and_grad(half)(z)
        return value, jnp.where(jnp.all(jnp.isfinite(slope)), slope, 0.0)
    r, slope = value_and_jacobian(spec, arrays, z)
    return 0.5 * jnp.sum(r**2), slope.T @ r
