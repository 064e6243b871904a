"""What stands between diffrax and its choice of steps."""

import diffrax
import jax.numpy as jnp
import pytest

from lumpedcable.solve.watching import Watching

LEAST = 1e-9  # s, of a step without a solution
LEASTS = jnp.asarray(1e-16), jnp.asarray(LEAST)


def solved(slope, until=1.0):
    steps = diffrax.PIDController(rtol=1e-6, atol=1e-9)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(slope), diffrax.Tsit5(), 0.0, until, 0.1, jnp.zeros(()),
        stepsize_controller=Watching(steps, (), jnp.zeros(()), LEASTS, ()),
        max_steps=4096, throw=False, saveat=diffrax.SaveAt(t1=True, controller_state=True),
    )  # fmt: skip


def test_steps_that_shrink_without_end_end_the_run():
    # nothing is defined from 0.3 s on: steps come nearer by a fifth of what is refused, 1e-9 after 13
    found = solved(lambda t, y, args: jnp.where(t < 0.3, 1.0, jnp.nan))
    assert found.result == diffrax.RESULTS.dt_min_reached
    assert found.stats["num_steps"] < 200
    assert found.ys is not None
    assert float(found.ys[0]) == pytest.approx(0.3, abs=10 * LEAST)


def test_a_jump_is_crossed_by_a_step_as_short_as_its_error_asks_for():
    # over a jump by 1e4 /s a step of h is wrong by some 1e4 h of 1e-9 that are allowed: 1e-13 s
    found = solved(lambda t, y, args: jnp.where(t < 0.3, 0.0, 1e4))
    assert found.result == diffrax.RESULTS.successful
    assert found.ys is not None
    assert float(found.ys[0]) == pytest.approx(0.7e4, rel=1e-9)


def test_a_step_that_is_kept_may_be_as_short_as_it_is():
    found = solved(lambda t, y, args: 1.0, until=1e-3 * LEAST)
    assert found.result == diffrax.RESULTS.successful
