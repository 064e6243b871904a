"""What samples show to have gone wrong."""

import functools
import operator

from jaxtyping import Array, Bool

from lumpedcable.scene.bodies import STEEP
from lumpedcable.solve.observe import Sample
from lumpedcable.status import Status

__all__ = ["signs"]


def signs(seen: Sample, limit: float = 1.0) -> dict[Status, Bool[Array, "..."]]:
    """Which of `status.SIGNS` samples show; `limit` is the Courant number that a step may have."""
    never = seen.finite & False
    upended = (least < STEEP for least in seen.upright.values())
    return {
        Status.BODY_UPENDED: functools.reduce(operator.or_, upended, never),
        Status.LINE_RUN_OUT: functools.reduce(operator.or_, seen.run_out.values(), never),
        Status.LENGTH_LOST: seen.lost,
        Status.STEP_BOUND_BROKEN: seen.courant > limit,
        Status.TOO_MANY_STEPS: seen.stuck == Status.TOO_MANY_STEPS,
        Status.STEP_NOT_FOUND: seen.stuck == Status.STEP_NOT_FOUND,
        Status.NON_FINITE: ~seen.finite,
        Status.LINE_REVERSED: seen.reversed,
    }
