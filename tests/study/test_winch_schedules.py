"""Winches whose tension changes: beside a drum on a spring, and what their drives do."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import run_text
from scipy.integrate import solve_ivp

from lumpedcable import response
from lumpedcable.scene import SceneError, load_study

EA, SPAN, FIRST, DRUM, DAMPING = 1e5, 50.0, 1e3, 500.0, 300.0
TIMES, TENSIONS = [1.0, 1.5, 4.0], [1e3, 3e3, 2e3]


def hauled(more="", output='duration = "6 s"\nevery = "0.1 s"\nquantities = ["tension", "energy"]'):
    return f"""
[materials.rope]
law = "linear"
EA = {EA}
[lines.rope]
material = "rope"
length = {SPAN}
segments = 10
mass = 0.1
start = {{ fixed = [{SPAN}, 0, 0] }}
[lines.rope.end.winch]
at = [0, 0, 0]
tension = {FIRST}
inertia = {DRUM}
damping = {DAMPING}
schedule = {{ time = {TIMES}, tension = {TENSIONS} }}
{more}
[output]
{output}
"""


def kept(t):
    return np.interp(t, [0.0, *TIMES], [FIRST, *TENSIONS])


def work(tension):
    """(1 + e) T - U (N): what a metre of line costs at a tension, and pulls out."""
    return tension * (1.0 + tension / EA) - tension**2 / (2.0 * EA)


def drum(drive, time):
    """Length (m), its rate (m/s) and what the drive remembers, of a drum on the line as a spring."""
    mass = DRUM + 0.1 * SPAN / (1.0 + FIRST / EA) / 3.0

    def moves(t, y):
        tension = EA * (SPAN / y[0] - 1.0)
        force, memory = drive(t, tension, y)
        return [y[1], (work(tension) - work(kept(t)) - DAMPING * y[1] + force) / mass, memory]

    start = [SPAN / (1.0 + FIRST / EA), 0.0, 0.0]
    found = solve_ivp(
        moves, (0.0, time[-1]), start, t_eval=time, rtol=1e-9, atol=1e-10, max_step=0.01
    )
    return found.y


@pytest.mark.slow
def test_a_drum_hauls_and_gives_as_its_tension_changes(tmp_path):
    ran = run_text(tmp_path, hauled())
    assert ran.statuses == ["OK"]
    length, speed, _ = drum(lambda t, tension, y: (0.0, 0.0), ran.time)
    assert np.ptp(length) > 1.0
    np.testing.assert_allclose(ran["payout"][0], length, atol=2e-3)
    np.testing.assert_allclose(ran["payout_speed"][0], speed, atol=5e-3)
    middle = ran["tension"][0].mean(axis=1)
    np.testing.assert_allclose(middle, EA * (SPAN / length - 1.0), atol=10.0)
    assert ran.outcomes[0].energy_closure < 1e-3
    assert "lost_control" in ran.energy


@pytest.mark.slow
def test_a_drive_that_watches_the_tension_follows_what_it_is_to_be(tmp_path):
    gain, again = 3.0, 0.8
    ran = run_text(tmp_path, hauled(f"control = {{ gain = {gain}, integral_time = {again} }}"))
    assert ran.statuses == ["OK"]

    def drive(t, tension, y):
        # the error as the winch feels it, in work a metre over the stretch that it keeps
        off = (work(tension) - work(kept(t))) / (1.0 + kept(t) / EA)
        return gain * off + gain / again * y[2], off

    length, speed, _ = drum(drive, ran.time)
    np.testing.assert_allclose(ran["payout"][0], length, atol=2e-3)
    np.testing.assert_allclose(ran["payout_speed"][0], speed, atol=5e-3)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow
def test_derivatives_know_of_kinks_that_steps_end_on(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(hauled(), encoding="utf-8")
    times = [f"lines.rope.end.winch.schedule.time.{k}" for k in range(2)]
    answer = response(path, times, "max tension at rope.start")
    slopes = np.asarray(jax.grad(answer)(jnp.array(TIMES[:2])))
    for k, slope in enumerate(slopes):
        away = 1e-3 * np.eye(2)[k]
        up, down = (float(answer(jnp.array(TIMES[:2]) + s * away)) for s in (1.0, -1.0))
        assert slope == pytest.approx((up - down) / 2e-3, rel=5e-3)


@pytest.mark.parametrize("method", ["rk4", pytest.param("tsit5", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_other_methods_do_the_same(tmp_path, method):
    ran = run_text(tmp_path, hauled() + f'[solver]\nmethod = "{method}"\n')
    assert ran.statuses == ["OK"]
    length, _, _ = drum(lambda t, tension, y: (0.0, 0.0), ran.time)
    np.testing.assert_allclose(ran["payout"][0], length, atol=2e-3)
    assert ran.outcomes[0].energy_closure < 1e-3


def test_at_rest_it_has_the_first_tension(tmp_path):
    ran = run_text(tmp_path, hauled(), "output={}")
    np.testing.assert_allclose(ran["tension"][0, 0], FIRST, rtol=1e-8)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("time = [1.0, 1.5, 4.0]", "time = [1.0, 4.0, 1.5]", "expected more than 4 s"),
        (
            "time = [1.0, 1.5, 4.0]",
            "time = [1.0, 1.5]",
            "expected 2 tensions, one per time, found 3",
        ),
        ("time = [1.0, 1.5, 4.0]", "time = [0, 1.5, 4.0]", "expected a positive time"),
        ("mass = 0.1", 'mass = 0.1\nmodel = "ideal"', "a winch with schedule"),
    ],
)
def test_what_is_no_schedule_is_told(tmp_path, old, new, words):
    path = tmp_path / "scene.toml"
    path.write_text(hauled().replace(old, new), encoding="utf-8")
    with pytest.raises(SceneError, match=words):
        load_study(path)
