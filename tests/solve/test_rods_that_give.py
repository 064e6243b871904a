"""Rods that give way by their EA: springs along themselves, at any step."""

import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text

from lumpedcable.scene import SceneError
from lumpedcable.solve.stretch import WEIGHTS

G = 9.81
MASS, ROD, LENGTH, SPRING = 100.0, 1.0, 10.0, 1e4  # kg, kg, m, N/m
SPEED, BELOW = 1.0, 10.009  # of the bob at the start (m/s), and how far it is under its place (m)
MATERIAL = 'gravity = 9.81\n[materials.wire]\nlaw = "inextensible"\n'
BOB = (
    f"{MATERIAL}EA = {SPRING * LENGTH}\n"
    f"[bodies.bob]\nmass = {MASS}\nposition = [0, 0, {-BELOW}]\nvelocity = [0, 0, {SPEED}]\n"
    'inertia = [1, 1, 1]\nfree = ["z"]\npoints.eye = [0, 0, 0]\n'
    + line_text("wire", "wire", LENGTH, 1, ROD / LENGTH, fixed(0, 0, 0), '"bob.eye"')
    + '[output]\nduration = "2 s"\nevery = "20 ms"\nquantities = ["position", "tension", "energy"]\n'
)


def level(EA, span):
    """A line of 10 m without weight between two places that are `span` (m) apart."""
    stiffness = "" if EA is None else f"EA = {EA}\n"
    return (
        MATERIAL.replace("gravity = 9.81\n", "") + stiffness
        + line_text("wire", "wire", 10, 5, 0.1, fixed(0, 0, 0), fixed(span, 0, 0))
        + '[solver]\nstep = "1 ms"\n[output]\nduration = "20 ms"\nevery = "10 ms"\n'
    )  # fmt: skip


def amplification(square):
    """Largest root of a step's amplification, of a motion with (omega dt)^2 = `square`."""
    steps = np.array([1.0, -2.0, 1.0, 0.0])
    return np.abs(np.roots(steps + square * np.array(WEIGHTS))).max()


class TestTheMeanThatATensionGoesBy:
    def test_is_of_second_order(self):
        assert sum(WEIGHTS) == pytest.approx(1.0, abs=1e-15)
        assert np.dot(WEIGHTS, [1, 0, -1, -2]) == pytest.approx(0.0, abs=1e-15)

    def test_bears_any_step_and_halves_what_is_too_stiff_for_it(self):
        assert max(amplification(square) for square in np.logspace(-6, 8, 500)) <= 1.0 + 1e-12
        assert amplification(1e12) == pytest.approx(0.5, abs=2e-3)

    @pytest.mark.parametrize(("steps", "lost"), [(60, 2e-4), (12, 0.02)])
    def test_hardly_damps_what_the_step_resolves(self, steps, lost):
        assert 0.0 < 1.0 - amplification((2.0 * np.pi / steps) ** 2) ** steps < lost


def exact(t):
    """Height of the bob (m): a third of the rod moves with it, half of it hangs on it."""
    rate = np.sqrt(SPRING / (MASS + ROD / 3.0))
    rest = -LENGTH - (MASS + 0.5 * ROD) * G / SPRING
    return rest + (-BELOW - rest) * np.cos(rate * t) + SPEED / rate * np.sin(rate * t)


@pytest.mark.slow
def test_a_bob_goes_on_bobbing(tmp_path):
    swing = np.ptp(exact(np.linspace(0.0, 0.7, 701)))
    off = []
    for step in ("10 ms", "5 ms"):
        ran = run_text(tmp_path, BOB, f"solver.step={step}")
        assert ran.statuses == ["OK"]
        where = ran["wire.position"][0, :, -1, 2]
        off.append(np.abs(where - exact(ran.time)).max() / swing)
        late = ran.time > 1.3
        assert np.ptp(where[late]) == pytest.approx(swing, rel=0.01)
        assert ran.outcomes[0].energy_closure < 2e-3
        # the spring's force, of the mean of the rod: half of its own inertia and weight go to either end
        pull = SPRING * (-where - LENGTH)
        assert np.abs(ran["wire.tension"][0, :, 0] - pull).max() < 0.01 * SPRING * swing
    assert off[0] < 0.03
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(("EA", "span"), [(1e6, 10.03), (1e5, 12.0)])
def test_a_taut_line_is_stretched_between_its_ends(tmp_path, EA, span):
    ran = run_text(tmp_path, level(EA, span))
    assert ran.statuses == ["OK"]
    np.testing.assert_allclose(ran["wire.tension"], EA * (span / 10.0 - 1.0), rtol=1e-9)


@pytest.mark.parametrize(("EA", "span"), [(None, 10.03), (1e6, 15.1)])
def test_a_line_that_would_stretch_without_EA_or_by_more_than_half_is_refused(tmp_path, EA, span):
    with pytest.raises(SceneError, match=f"that reach over the {span} m"):
        run_text(tmp_path, level(EA, span))
