"""Derivatives of a released line, taken backwards, forwards and by differences, past the first slack."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import keep_blocks_alone

from benchmarks.engine import Runner, scene_of
from lumpedcable.solve import reverse
from lumpedcable.solve.integrate import advance, begin
from lumpedcable.solve.reverse import block_length, scan_in_blocks
from lumpedcable.study.compiled import RUN_ONCE

SEGMENTS, STEPS, SPAN = 12, 240, 0.25


@pytest.mark.parametrize(
    "only_blocks",  # all steps' states are kept, or those of blocks alone
    [True, pytest.param(False, marks=pytest.mark.slow)],
)
def test_backward_forward_and_differences_agree(monkeypatch, only_blocks):
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

    def compiled(f):
        return jax.jit(f, compiler_options=RUN_ONCE)

    at = model.lines["rope"].mass
    steps = jnp.asarray(STEPS)

    def both(mass):
        found, slopes = jax.jvp(lambda m: moved(m, steps), (mass,), (jnp.ones_like(mass),))
        return *found, slopes[0]

    both = compiled(both)
    _, tension, forward = both(at)
    assert float(jnp.min(tension)) == 0.0, "no segment went slack"
    if only_blocks:
        keep_blocks_alone(monkeypatch)
    # a loop is transposed only if the number of its turns is known
    backward = float(compiled(jax.grad(lambda mass: moved(mass, STEPS)[0]))(at))
    np.testing.assert_allclose(backward, float(forward), rtol=1e-10)
    h = 1e-5 * at
    difference = float((both(at + h)[0] - both(at - h)[0]) / (2.0 * h))
    # (h/m)^2 and rounding over h are both far below
    np.testing.assert_allclose(float(forward), difference, rtol=1e-6)


def body(x, k):
    """x <- x + h sin(x), a thousand numbers of 8 bytes."""
    x = x + 1e-3 * jnp.sin(x * (1.0 + 1e-3 * k))
    return x, x[0]


def plain(x, count):
    """All steps kept."""
    x, seen = jax.lax.scan(body, x, jnp.arange(count))
    return jnp.sum(x) + jnp.sum(seen)


def blocks(x, count):
    """The same with as many kept as `block_length` says."""
    x, seen = scan_in_blocks(body, x, count, block_length(count, x))
    return jnp.sum(x) + jnp.sum(seen)


X = jnp.linspace(0.1, 2.0, 1000)


def memory(f, count):
    """Bytes that the way there and back needs beside its input and output."""
    compiled = jax.jit(jax.grad(f), static_argnums=1).lower(X, count).compile()
    return compiled.memory_analysis().temp_size_in_bytes


@pytest.mark.parametrize("count", [1, 2, 7, 1000, 1009])  # blocks of one turn, of some; with a rest
def test_a_loop_in_blocks_gives_what_a_loop_gives(monkeypatch, count):
    """Values and derivatives."""
    keep_blocks_alone(monkeypatch)
    value, slope = jax.value_and_grad(blocks)(X, count)
    expected, steep = jax.value_and_grad(plain)(X, count)
    assert value == pytest.approx(float(expected), rel=1e-13)
    np.testing.assert_allclose(slope, steep, rtol=1e-12)


def test_memory_of_a_loop_in_blocks_grows_with_the_root_of_its_turns(monkeypatch):
    """Sixteen times the turns: all of them are kept by the plain loop, four times as many by blocks."""
    keep_blocks_alone(monkeypatch)
    assert memory(plain, 16000) / memory(plain, 1000) > 12.0
    assert memory(blocks, 16000) / memory(blocks, 1000) < 6.0


def test_what_fits_into_the_memory_that_is_always_there_is_kept():
    """All turns up to `KEPT`; from there on less memory, which grows with the root of the turns."""
    most, near = reverse.KEPT // X.nbytes, reverse.BLOCK // X.nbytes
    assert block_length(most, X) == most
    assert block_length(most + 1, X) == near
    assert block_length(most, X, runs=4) == max(near // 4, round(most**0.5))
    assert block_length(near**2 * 4, X) == 2 * near  # the root
    assert memory(blocks, most) == pytest.approx(memory(plain, most), rel=1e-3)
    assert memory(blocks, 2 * most) < 0.2 * memory(plain, most)
    assert memory(blocks, 32 * most) < 6.0 * memory(blocks, 2 * most)
