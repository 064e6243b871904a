"""Lines that are alike, done together: the same results, from a program as long as that of one line."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import fixed, length_of, line_text, run_text
from jax import lax

from lumpedcable.model.line import alike
from lumpedcable.study.alike import together
from lumpedcable.study.compiled import configure

configure()

NAMES = ("a", "b", "c", "d")


def numbers_of(names, nodes=6):
    rng = np.random.default_rng(1)
    return {name: {"x": rng.normal(size=(2, nodes)), "k": rng.uniform(1, 2, ())} for name in names}


def joined(lines, dt, turns):
    """Springs in a row, line by line, of which the last node of each pulls a body."""
    body = jnp.zeros(2)

    def turn(i, carry):
        body, places, speeds = carry
        pull, after, rates = jnp.zeros(2), {}, {}
        for name, x in places.items():
            force = lines[name]["k"] * (x[:, 1:] - x[:, :-1])
            total = jnp.pad(force, ((0, 0), (0, 1))) - jnp.pad(force, ((0, 0), (1, 0)))
            speed = speeds[name] + dt * total / (1.0 + jnp.sum(x**2))
            moved = lax.dynamic_update_slice(x, x[:, :1] + dt * speed[:, :1], (0, 0))
            moved = moved + dt * speed.at[:, 0].set(0.0)
            pull = pull + total[:, -1] + jnp.diag(total[:, -2:]) @ jnp.ones((2, 2))
            after[name], rates[name] = moved.at[:, -1].add(body), speed
        return body + 0.01 * pull, after, rates

    start = {name: line["x"] for name, line in lines.items()}
    # places and speeds start as the same values
    return lax.fori_loop(0, turns, turn, (body, start, start))


def assert_same(found, expected, rtol=1e-13):
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(a, b, rtol=rtol, atol=rtol)


class TestTogether:
    def test_results_are_those_of_the_function(self):
        lines = numbers_of(NAMES)
        found = together(joined, [NAMES], lines, 0.1, 5)
        assert_same(found, joined(lines, 0.1, 5))

    def test_a_program_of_many_lines_is_hardly_longer(self):
        def rolled(lines, dt, turns):
            return together(joined, [list(lines)], lines, dt, turns)

        few, many = (numbers_of([f"l{k}" for k in range(n)]) for n in (2, 12))
        plain, rolls = (
            [length_of(function, lines, 0.1, 5) for lines in (few, many)]
            for function in (joined, rolled)
        )
        # what joins them is still done for each: an end that pulls, and taking apart at the end
        assert rolls[1] - rolls[0] < 0.4 * (plain[1] - plain[0])

    @pytest.mark.parametrize("groups", [[("a", "c")], [("a", "b"), ("c", "d")], []])
    def test_of_some_lines(self, groups):
        lines = numbers_of(NAMES)
        found = together(joined, groups, lines, 0.1, 5)
        assert_same(found, joined(lines, 0.1, 5))

    def test_lines_of_other_shapes_stay_apart(self):
        lines = numbers_of(("a", "b")) | numbers_of(("c", "d"), 9)
        assert alike(lines) == [["a", "b"], ["c", "d"]]
        # told that all are alike, it finds which arrays are not
        assert_same(together(joined, [NAMES], lines, 0.1, 5), joined(lines, 0.1, 5))

    def test_an_end_that_only_one_line_has(self):
        def function(lines, t):
            ends = {name: jnp.sin(x["x"][:, 0] * x["k"]) + t for name, x in lines.items()}
            ends["b"] = ends["b"] * lines["c"]["k"]
            return {name: end.sum() * lines[name]["x"] for name, end in ends.items()}

        lines = numbers_of(NAMES)
        assert_same(together(function, [NAMES], lines, 0.3), function(lines, 0.3))

    def test_branches_and_tables(self):
        def function(lines, i):
            def of(line):
                x = lax.cond(i > 1, jnp.sin, jnp.cos, line["x"])
                _, sums = lax.scan(lambda c, r: (c + r, c), jnp.zeros(()), x[0])
                return sums + lax.dynamic_slice(x, (0, i), (2, 1))[0], x[0][jnp.argmax(x[1])]

            return {name: of(line) for name, line in lines.items()}

        lines = numbers_of(NAMES)
        for i in (0, 2):
            assert_same(together(function, [NAMES], lines, i), function(lines, i))


WIRE = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
"""


def scene_of_lines(which):
    """Lines apart from each other, let go at their ends, each of its own mass and length."""
    lines = "".join(
        line_text(f"l{i}", "wire", 20 + k, 6, 1.0 + 0.3 * k, fixed(0, k, 0), fixed(19, k, -2))
        + f'[events.e{i}]\nbreaks = "l{i}.end"\ntime = "5 ms"\nstart = "{5 + k} ms"\n'
        for i, k in enumerate(which)
    )
    return (
        WIRE + lines + '[output]\nduration = "80 ms"\nevery = "10 ms"\n'
        'quantities = ["position", "velocity"]\n[solver]\nstep = "50 us"\n'
    )


@pytest.mark.slow
def test_lines_of_one_scene_move_as_each_does_alone(tmp_path):
    whole = run_text(tmp_path, scene_of_lines((0, 1, 2)))
    for k in (0, 2):
        alone = run_text(tmp_path, scene_of_lines((k,)))
        for quantity in ("position", "velocity"):
            a, b = whole[f"l{k}.{quantity}"][0], alone[quantity][0]
            assert np.abs(b).max() > 0.5  # it falls for 75 ms
            np.testing.assert_allclose(a[:, :, 0], b[:, :, 0], atol=1e-9 * np.abs(b).max())
            np.testing.assert_allclose(a[:, :, 2], b[:, :, 2], atol=1e-9 * np.abs(b).max())
