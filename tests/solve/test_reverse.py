"""Derivatives of a released line, taken backwards, forwards and by differences, past the first slack."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.engine import Runner, scene_of
from lumpedcable.solve.integrate import advance, begin

SEGMENTS, STEPS, SPAN = 12, 240, 0.25


def test_backward_forward_and_differences_agree():
    """The line goes slack once the front has come back; where it is, sqrt(T') has no slope."""
    runner = Runner(scene_of(f"segments={SEGMENTS}"))
    model = jax.tree.map(lambda x: x[0], runner.ready.model)
    plan = dataclasses.replace(runner.plan, outputs=1, recoils=(), quantities=("tension",))

    def moved(mass, steps):
        numbers = runner.numbers(SPAN, STEPS)._replace(steps=steps)
        line = dataclasses.replace(model.lines["rope"], mass=mass)
        mine = dataclasses.replace(model, lines={"rope": line})
        state, _ = begin(mine, plan, numbers)
        state, sample = advance(mine, plan, numbers, state, 0, 1)
        return state.y.displacement["rope"][0, -1], sample.fields["rope"]["tension"][0]

    at = model.lines["rope"].mass
    steps = jnp.asarray(STEPS)
    _, tension = jax.jit(moved)(at, steps)
    assert float(jnp.min(tension)) == 0.0, "no segment went slack"
    value = jax.jit(lambda mass: moved(mass, steps)[0])
    forward = float(jax.jit(jax.jacfwd(lambda mass: moved(mass, steps)[0]))(at))
    # a loop is transposed only if the number of its turns is known
    backward = float(jax.jit(jax.grad(lambda mass: moved(mass, STEPS)[0]))(at))
    h = 1e-5 * at
    difference = float((value(at + h) - value(at - h)) / (2.0 * h))
    np.testing.assert_allclose(backward, forward, rtol=1e-10)
    # (h/m)^2 and rounding over h are both far below
    np.testing.assert_allclose(forward, difference, rtol=1e-6)
