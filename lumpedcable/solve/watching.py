"""Watches at every step that a solver takes which chooses its steps itself."""

import dataclasses
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.solve.observe import Recoil, Watch, watch

__all__ = ["Watching"]


class Watching(diffrax.AbstractAdaptiveStepSizeController):
    """Chooses steps as `controller` does, watches those that it accepts, and ends where none is left.

    diffrax shows its steps to nobody else. The state is that of `controller` and the watches, which are
    `seen` before the first step. The model is `args`; the solver's times count from `start` (s).

    A step of less than `least` (s) that is refused ends the run, since they would get ever shorter until
    time stands still: the first where its error is too large, as over a jump, which many are short
    enough for; the second where its stages have no solution or its error is no number.
    """

    controller: diffrax.PIDController
    seen: tuple[Watch, ...]
    start: Float[Array, ""]
    least: tuple[Float[Array, ""], Float[Array, ""]]
    recoils: tuple[Recoil, ...] = eqx.field(static=True)

    def __init__(
        self, controller: diffrax.PIDController, seen: tuple[Watch, ...],
        start: Float[Array, ""], least: tuple[Float[Array, ""], Float[Array, ""]],
        recoils: tuple[Recoil, ...],
    ):  # fmt: skip
        self.controller, self.seen, self.recoils = controller, seen, recoils
        self.start, self.least = start, least

    @property
    def rtol(self) -> Any:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As of `controller`."""
        return self.controller.rtol

    @property
    def atol(self) -> Any:  # pyright: ignore[reportIncompatibleVariableOverride]
        """As of `controller`."""
        return self.controller.atol

    @property
    def norm(self) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """As of `controller`."""
        return self.controller.norm

    def wrap(self, direction):
        """The same around the wrapped `controller`."""
        return dataclasses.replace(self, controller=self.controller.wrap(direction))

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """End of the first step; states."""
        end, inner = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        return end, (inner, self.seen)

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):  # fmt: skip
        """As of `controller`, or its end; the watches see a step that is kept."""
        inner, seen = controller_state
        keep, next_start, next_end, jumped, inner, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, inner
        )
        t, dt = self.start + t1, jnp.asarray(t1 - t0)
        after = watch(args, y1_candidate, seen, self.recoils, t, dt)
        seen = jax.tree.map(lambda new, old: jnp.where(keep, new, old), after, seen)
        measured = jnp.isfinite(self.norm(y_error))
        ended = ~keep & (t1 - t0 < jnp.where(measured, *self.least))
        result = diffrax.RESULTS.where(ended, diffrax.RESULTS.dt_min_reached, result)
        return keep, next_start, next_end, jumped, (inner, seen), result
