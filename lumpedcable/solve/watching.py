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
    """Chooses steps as `controller` does, and watches those that it accepts.

    diffrax shows its steps to nobody else. The state is that of `controller` and the watches, which are
    `seen` before the first step. The model is `args`; the solver's times count from `start` (s).
    """

    controller: diffrax.PIDController
    seen: tuple[Watch, ...]
    start: Float[Array, ""]
    recoils: tuple[Recoil, ...] = eqx.field(static=True)

    def __init__(
        self, controller: diffrax.PIDController, seen: tuple[Watch, ...],
        start: Float[Array, ""], recoils: tuple[Recoil, ...],
    ):  # fmt: skip
        self.controller, self.seen, self.start, self.recoils = controller, seen, start, recoils

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
        """As of `controller`; the watches see a step that is kept."""
        inner, seen = controller_state
        keep, next_start, next_end, jumped, inner, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, inner
        )
        t, dt = self.start + t1, jnp.asarray(t1 - t0)
        after = watch(args, y1_candidate, seen, self.recoils, t, dt)
        seen = jax.tree.map(lambda new, old: jnp.where(keep, new, old), after, seen)
        return keep, next_start, next_end, jumped, (inner, seen), result
