"""A number of a run as a function that jax differentiates and batches, against d'Alembert's solution."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import HOOKE

import lumpedcable as lc

EA, MASS, PULL = 1e6, 1.0, 50e3  # of HOOKE
KEYS = ("lines.rope.end.held.pretension", "materials.hooke.EA", "lines.rope.mass")
HERE = np.array([PULL, EA, MASS])
SHORT = {"rope.segments": 20, "output.duration": "50 ms"}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("response") / "hooke.toml"
    path.write_text(HOOKE.replace('EA = "1 MN"', 'EA = "1 MN"\nbreaking_strength = "90 kN"'))
    return path


@pytest.fixture(scope="module")
def speed(scene):
    return lc.response(scene, ["pretension", "hooke.EA", "rope.mass"], "last velocity at rope.end",
                       SHORT)  # fmt: skip


def exact(x):
    """The speed of the end of a long line of Hooke's law that is let go (m/s): T / sqrt(EA m)."""
    pull, stiff, mass = x
    return pull / np.sqrt(stiff * mass)


def test_it_knows_what_it_is_of(speed):
    assert speed.keys == KEYS
    assert speed.units == ("N", "N", "kg/m")
    np.testing.assert_array_equal(speed.values, HERE)
    assert (speed.of, speed.unit) == ("last velocity at rope.end", "m/s")
    assert repr(speed) == f"Response(last velocity at rope.end (m/s) by {', '.join(KEYS)})"


@pytest.mark.slow
def test_values_and_derivatives_in_both_modes_are_those_of_the_exact_wave(speed):
    value, back = jax.value_and_grad(speed)(speed.values)
    assert float(speed(speed.values)) == pytest.approx(float(value), rel=1e-12)
    # twenty segments leave a ripple of a per mille or two behind the front
    assert float(value) == pytest.approx(exact(HERE), rel=2e-3)
    slopes = exact(HERE) * np.array([1.0, -0.5, -0.5]) / HERE
    np.testing.assert_allclose(back, slopes, rtol=0.02)
    np.testing.assert_allclose(jax.jacfwd(speed)(speed.values), back, rtol=1e-9)
    # forces and masses all k times as large move alike: Euler's theorem of homogeneous functions
    assert float(back @ HERE) == pytest.approx(0.0, abs=1e-9 * float(value))


def test_many_at_once(speed):
    many = jnp.array([[0.5, 1.0, 1.0], [1.0, 1.0, 1.0], [1.5, 1.0, 1.0]]) * HERE
    found = np.asarray(jax.jit(jax.vmap(speed))(many))
    np.testing.assert_allclose(found, exact(many.T), rtol=2e-3)


@pytest.mark.slow
def test_its_history_is_that_of_a_run(scene, speed):
    ran = lc.run(scene, SHORT)
    end = ran.line("rope").velocity[0, :, -1, 0]
    np.testing.assert_allclose(speed.history(speed.values), np.abs(end), atol=1e-9)
    np.testing.assert_allclose(speed.time, end.time, rtol=1e-12)


@pytest.mark.parametrize("ask", [lambda f: f, lambda f: f.history], ids=["value", "history"])
def test_second_derivatives_are_refused(speed, ask):
    # statics holds its slope still where it carries derivatives through: its second ones are wrong
    with pytest.raises(NotImplementedError, match=r"second derivatives through its state of rest"):
        jax.hessian(ask(speed))(speed.values)


@pytest.mark.slow
def test_waves_too_fast_for_its_steps_give_no_number(scene, speed):
    faster = HERE * [1.0, 64.0, 1.0]  # 8000 m/s: more than a segment of 5 m in a step of 1 ms
    assert np.isnan(float(speed(faster)))
    for slopes in (jax.grad(speed)(faster), jax.jacfwd(speed)(faster)):
        assert np.all(np.isnan(slopes))  # zeros would be those of a stationary point
    histories = jax.jacfwd(speed.history)(faster), jax.jacrev(speed.history)(faster)
    assert np.all(np.isnan(histories))
    asked = ["pretension", "EA", "rope.mass"], "last velocity at rope.end"
    short = SHORT | {"output.duration": "20 ms"}  # before the wall's answer is there
    roomy = lc.response(scene, *asked, short, spare=3.0)
    assert float(roomy(faster)) == pytest.approx(exact(faster), rel=2e-3)


@pytest.mark.parametrize(
    "here", [[-1.0, EA, MASS], [PULL, 0.0, MASS], [PULL, EA, -MASS], [PULL, np.nan, MASS]]
)
def test_numbers_that_their_keys_cannot_have_give_no_number(speed, here):
    assert np.isnan(speed(here))
    assert np.all(np.isnan(jax.grad(speed)(np.array(here))))


def test_no_number_is_lost_at_a_bound(scene):
    # no speed in the beginning, and none without a pull
    early = lc.response(scene, ["pretension"], "first velocity at rope.end", SHORT)
    assert float(early([0.0])) == 0.0


@pytest.mark.slow
def test_a_given_step_above_the_bound_is_judged_as_by_a_run(tmp_path):
    # the bound (3.8 ms) is that of strains that the rope never comes to: at its own 5 ms would do
    path, key = tmp_path / "stiffens.toml", "materials.hooke.coefficients.0"
    law = 'law = "polynomial"\ncoefficients = [1e6, 0, 1e6]\nmax_strain = 0.5'
    path.write_text(HOOKE.replace('law = "linear"\nEA = "1 MN"', law))
    given = {"rope.segments": 20, "output.duration": "45 ms", "output.every": "4.5 ms",
             "solver.step": "4.5 ms"}  # fmt: skip
    speed = lc.response(path, [key], "last velocity at rope.end", given)
    for times in (1.0, 4.0):  # of four times the stiffness samples tell too
        ran = lc.run(path, given | {key: float(times * EA)})
        assert ran.status == (["ok"] if times == 1.0 else ["step_bound_broken"])
        history = np.abs(ran.line("rope").velocity[0, :, -1, 0]) if times == 1.0 else np.nan
        np.testing.assert_allclose(speed.history([times * EA]), history, atol=1e-9)
    assert float(jax.grad(speed)(speed.values)[0]) < 0.0


@pytest.mark.parametrize(
    ("by", "of", "told"),
    [
        (["hooke.EB"], None, 'found "hooke.EB"; did you mean "materials.hooke.EA"?'),
        (["rope.segments"], None, "a number that varies smoothly"),
        (["hooke.breaking_strength"], None, "which runs are judged by"),
        (["EA", "materials.hooke.EA"], None, "every number once"),
        ("EA", None, "in a list"),
        ([], None, "one key or more"),
        (["EA"], "max velocity at rope.ent", "rope.ent"),
        ([3], None, "in a list"),
        (["EA"], 3, "expected a text as"),
    ],
)
def test_what_is_asked_wrongly_is_told(scene, by, of, told):
    with pytest.raises(ValueError, match=told.replace("?", r"\?")):
        lc.response(scene, by, of)


@pytest.mark.parametrize("x", [["45 kN"], [1e6 + 1e6j], [None], [True]])
def test_what_is_no_real_number_is_told(speed, x):
    with pytest.raises(ValueError, match="expected real numbers in SI units, found "):
        speed(x)


def test_a_spare_that_is_no_share_is_told(scene):
    with pytest.raises(ValueError, match="spare: expected a share of at least 0, found 'a'"):
        lc.response(scene, ["EA"], spare="a")


def test_a_number_of_a_csv_file_is_told(tmp_path):
    (tmp_path / "path.csv").write_text("t,x,y,z\n0,95,0,0\n0.1,95.1,0,0\n")
    held = '{ held = { pretension = "50 kN", direction = [1, 0, 0] } }'
    text = HOOKE.replace(held, '{ motion = { file = "path.csv" } }').replace(
        "rope.end", "rope.start"
    )
    (tmp_path / "scene.toml").write_text(text)
    key = "lines.rope.end.motion.position.1.0"
    with pytest.raises(ValueError, match="data of a CSV file cannot be free: write them out"):
        lc.response(tmp_path / "scene.toml", [key], "max tension at rope.start")


def test_another_number_of_numbers_is_told(speed):
    with pytest.raises(ValueError, match=r"expected 3 numbers .* found an array of shape \(2,\)"):
        speed([1.0, 2.0])
    with pytest.raises(ValueError, match="run: expected one from 0 to 0, found 3"):
        lc.response("configs/hard/snap.toml", ["EA"], run=3)


@pytest.mark.parametrize("spare", [np.nan, np.inf, -0.5])
def test_a_share_of_steps_is_one(scene, spare):
    with pytest.raises(ValueError, match="spare: expected a share of at least 0, found"):
        lc.response(scene, ["pretension"], "last velocity at rope.end", SHORT, spare=spare)


def test_more_steps_than_anybody_waits_for_are_refused(scene):
    with pytest.raises(ValueError, match="more steps are needed than may be taken"):
        lc.response(scene, ["pretension"], "last velocity at rope.end", SHORT, spare=1e9)
