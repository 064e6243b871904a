"""configs/snapback.toml as it is: displacement and energy of the eight runs."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_scenes

from lumpedcable.scene import load_study

CONFIG = Path(__file__).parents[2] / "configs" / "snapback.toml"
# Displacement of the broken end at 200 ms (m), independent 1-D chain of 4000 undamped segments,
# law cut at zero, tangential drag per length pi d/2 rho Ct v|v|, rho 1025; order of the sweep
# (pretension slowest, break time fastest: 5 ms, 50 ms). Weight bends the line by centimetres only.
DISPLACEMENT = (
    5.535231946, 5.086836194, 10.58310588, 9.878741994,
    13.44809269, 12.72505865, 16.71312221, 16.0599724,
)  # fmt: skip


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    return run_scenes(tmp_path_factory.mktemp("snapback"), load_study(CONFIG, []))


def test_all_runs_end_well(ran):
    assert ran.statuses == ["OK"] * 8
    assert ran.attributes["coordinates"] == 2  # gravity bends it in one plane


def test_displacement_of_the_broken_end(ran):
    found = [o.recoils["rope.end"]["end_displacement"] for o in ran.outcomes]
    np.testing.assert_allclose(found, DISPLACEMENT, rtol=3e-3)
    ends = ran["position"][:, :, -1]
    np.testing.assert_allclose(np.linalg.norm(ends[:, -1] - ends[:, 0], axis=-1), found, rtol=1e-12)


def test_energy_closes(ran):
    assert max(o.energy_closure for o in ran.outcomes) < 2e-3
    # closure is the largest residual over the largest of kinetic energy and losses together
    stored = sum(v for k, v in ran.energy.items() if not k.startswith(("work", "lost", "res")))
    work = sum(v for k, v in ran.energy.items() if k.startswith("work_"))
    lost = sum(v for k, v in ran.energy.items() if k.startswith("lost_"))
    residual = stored - stored[:, :1] - work + lost
    scale = np.max(np.abs(ran.energy["residual"]))
    np.testing.assert_allclose(residual, ran.energy["residual"], atol=1e-6 * scale, rtol=0)
    released = np.max(ran.energy["kinetic"] + lost, axis=1)
    expected = np.max(np.abs(residual), axis=1) / released
    np.testing.assert_allclose([o.energy_closure for o in ran.outcomes], expected, rtol=1e-6)


def test_losses_are_losses(ran):
    # drag, viscosity and friction take energy away and never give it back
    for kind in ("lost_drag", "lost_viscosity"):
        assert np.all(np.diff(ran.energy[kind], axis=1) >= -1e-9 * np.max(ran.energy[kind]))


def test_what_was_stored_is_what_the_law_stores(ran):
    # strain energy at the start, by Gauss quadrature of eq. 5 from the slack strain up to the
    # strain of the pretension; the weight changes it by parts in a thousand
    from nylon_line import LENGTH, RUNS, SLACK_STRAIN, tension

    x, w = np.polynomial.legendre.leggauss(40)
    for k, run in enumerate(RUNS):
        half = 0.5 * (run.e0 - SLACK_STRAIN)
        stored = LENGTH * half * np.sum(w * tension(SLACK_STRAIN + half * (1.0 + x)))
        assert ran.energy["strain"][2 * k, 0] == pytest.approx(stored, rel=2e-3)
