"""Finding the parameters: Levenberg-Marquardt, BFGS and L-BFGS of optimistix, each one program."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.fitting.arrays import Arrays, Spec
from lumpedcable.fitting.residual import failed_runs, penalised, residual, value_and_jacobian
from lumpedcable.study.compiled import RUN_OFTEN
from lumpedcable.study.kept import program

__all__ = ["REVERSE_FROM", "Found", "loss", "search", "searches"]

FIRST_STEP_SIZE = 100.0
"""One over the first damping, relative to the curvature of the sum of squares."""
LEAST = 0.1
"""Least norm of a column in the damping, over that of the longest."""
LINEAR, FREER = 1e-3, 1e3
"""Predicted gain over the loss below which damping falls so much faster."""
FREE = 1e12
"""One over a damping that holds nothing back: a step that small is no end before."""
NOTHING = 1e-6
"""Predicted gain over the loss that is not worth another step, far below what the noise leaves open.
Of a loss that forgives outliers, whose steps come nearer by a share each and not by digits, over what
one deviation as large as the noise costs, if that is less."""
MOST_IDLE, FEW_IDLE = 8, 3
"""Evaluations one after the other without progress at which a search ends (a refused step is a twentieth
of the one before); and where none is predicted either."""
REVERSE_FROM = 9
"""Free numbers from which a gradient is taken in reverse."""


class Found(NamedTuple):
    """Where a search ended: parameters z, what is left there, and what it took.

    `steps` are evaluations of the model, each with its derivatives; in `failed` runs of the scene
    the run failed (-1: not counted). `residual` (n,) is what was squared, `slope` (n, p) its
    derivatives by z (once a search is over, at `before_bounds`), `flat` the model's answer, all at the
    end.
    """

    z: Float[Any, " p"]
    residual: Float[Any, " n"]
    slope: Float[Any, "n p"]
    flat: Float[Any, " m"]
    steps: Int[Any, ""]
    failed: Int[Any, ""]
    converged: Bool[Any, ""]


class _Counted(eqx.Module):
    inner: Any
    failed: Int[Array, ""]
    gained: Bool[Array, ""]
    idle: Int[Array, ""]


class TrustRegion(optx.AbstractSearch):
    """The classical trust region, that counts failed runs and knows when rounding is all that is left.

    A step whose predicted gain is below the rounding of the loss is taken rather than refused for
    ever, so that the search ends.
    """

    runs: int
    forgiving: bool
    inner: optx.ClassicalTrustRegion = optx.ClassicalTrustRegion(
        high_cutoff=0.75, low_cutoff=1e-3, high_constant=6.0, low_constant=0.05
    )

    def init(self, y, f_info_struct):
        """No run has failed."""
        inner = self.inner.init(y, f_info_struct)
        inner = eqx.tree_at(lambda s: s.step_size, inner, jnp.asarray(FIRST_STEP_SIZE))
        return _Counted(inner, jnp.zeros((), int), jnp.ones((), bool), jnp.zeros((), int))

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
        # what is left is linear: damping would only keep the parameters that do little from moving
        linear = accept & ~first_step & (gain <= LINEAR * now)
        size = jnp.where(linear & (size < FREE), size * FREER, size)
        inner = eqx.tree_at(lambda s: s.step_size, inner, size)
        failed = state.failed + failed_runs(self.runs, f_eval_info.residual)
        nothing = NOTHING * (jnp.minimum(now, 0.5) if self.forgiving else now)
        gained = first_step | (gain > nothing)
        better = first_step | (accept & (now - after > nothing))
        idle = jnp.where(better, 0, state.idle + 1)
        return size, accept | settled, result, _Counted(inner, failed, gained, idle)


class Scaled(optx.AbstractDescent):
    """Marquardt's step: the least squares of J d + r and sqrt(lambda) D d, D the norms of J's columns.

    lambda is one over the step size (Marquardt, J. SIAM 11, 1963). A column far shorter than the
    longest counts as longer than it is: a parameter that does next to nothing waits until the others
    are found, or it would run off and take the model where it has no answer.
    """

    def init(self, y, f_info_struct):
        """Nothing is known yet."""
        n = f_info_struct.residual.shape[0]
        return jnp.zeros((n, y.shape[0])), jnp.zeros(n)

    def query(self, y, f_info, state):
        """J and r at an accepted point."""
        return f_info.jac.as_matrix(), f_info.residual

    def step(self, step_size, state):
        """The step for a damping."""
        slope, r = state
        norms = jnp.sqrt(jnp.sum(slope**2, axis=0))
        norms = jnp.maximum(norms, LEAST * jnp.max(norms))
        norms = jnp.where(norms > 0.0, norms, 1.0)
        damping = jnp.diag(jnp.full(norms.shape, jnp.sqrt(1.0 / step_size)))
        q, upper = jnp.linalg.qr(jnp.concatenate([slope / norms, damping]))
        right = q.T @ jnp.concatenate([r, jnp.zeros(norms.shape)])
        change = jax.scipy.linalg.solve_triangular(upper, right) / norms
        return -change, optx.RESULTS.successful


class Marquardt(optx.AbstractGaussNewton):
    """Levenberg-Marquardt with `TrustRegion` and `Scaled`.

    It also ends where no step is better any more: a minimum to rounding, or to the little chaos of a
    line that goes slack.
    """

    rtol: float
    atol: float
    search: Any
    norm: Any = optx.max_norm
    descent: Any = Scaled()
    verbose: Any = eqx.field(default=lambda **kwargs: None, static=True)

    def terminate(self, fn, y, args, options, state, tags):
        """Whether the values have settled, or too many steps made nothing better."""
        counted = state.search_state
        free = counted.inner.step_size >= FREE
        stuck = ~counted.gained & (free | (counted.idle >= FEW_IDLE))
        return (state.terminate & free) | stuck | (counted.idle >= MOST_IDLE), state.result


@partial(program, static=("spec", "solver", "tolerance", "max_steps"), options=RUN_OFTEN)
def search(
    spec: Spec, arrays: Arrays, z: Float[Array, " p"], solver: str, tolerance: float, max_steps: int
) -> Found:
    """One search from z."""
    return _search(spec, arrays, z, solver, tolerance, max_steps)


@partial(program, static=("spec", "solver", "tolerance", "max_steps", "axes"), options=RUN_OFTEN)
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
        region = TrustRegion(runs, spec.loss != "squares")
        rule = Marquardt(tolerance, tolerance, region)  # pyright: ignore[reportCallIssue]
        solution = optx.least_squares(
            lambda z, a: residual(spec, a, z), rule,
            z, arrays, max_steps=max_steps, throw=False, has_aux=True,
        )  # fmt: skip
        found = solution.state.f_info
        # the aux of the solution itself is that of the accepted place before
        r, slope, flat = found.residual, found.jac.as_matrix(), solution.state.aux
        failed = solution.state.search_state.failed
    else:
        kind = {"bfgs": optx.BFGS, "l-bfgs": optx.LBFGS}[solver]
        solution = optx.minimise(
            lambda z, a: loss(spec, a, z), kind(tolerance, tolerance), z, arrays,  # pyright: ignore[reportCallIssue]
            max_steps=max_steps, throw=False,
        )  # fmt: skip
        r, flat, slope = value_and_jacobian(spec, arrays, solution.value)
        failed = jnp.full((), -1)
    steps, good = solution.stats["num_steps"], solution.result == optx.RESULTS.successful
    return Found(solution.value, r, slope, flat, steps, failed, good)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def loss(spec: Spec, arrays: Arrays, z: Float[Array, " p"]) -> Float[Array, ""]:
    """Half the sum of squares of `penalised`."""
    return 0.5 * jnp.sum(penalised(spec, arrays, z)[0] ** 2)


@loss.defjvp
def _loss_jvp(spec, primals, tangents):
    arrays, z = primals
    value, slope = value_and_gradient(spec, arrays, z)
    return value, slope @ tangents[1]


def value_and_gradient(spec: Spec, arrays: Arrays, z: Float[Array, " p"]):
    """`loss` and its gradient: forward for few parameters, in reverse where steps are fixed."""
    if all(group.steps is not None for group in spec.groups) and z.size >= REVERSE_FROM:

        def half(z):
            return 0.5 * jnp.sum(penalised(spec, arrays, z)[0] ** 2)

        value, slope = jax.value_and_grad(half)(z)
        return value, jnp.where(jnp.all(jnp.isfinite(slope)), slope, 0.0)
    r, _, slope = value_and_jacobian(spec, arrays, z)
    return 0.5 * jnp.sum(r**2), slope.T @ r
