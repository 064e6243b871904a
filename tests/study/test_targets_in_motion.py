"""Lines whose lengths targets find, in runs that move from there."""

import jax
import numpy as np
import pytest
from engine_runs import NYLON, fixed, line_text, run_text
from moored_buoy import BUOY, target

import lumpedcable as lc

SPAN, PULL = 70.0, 180e3  # m, N
ROPE = (
    NYLON
    + line_text("rope", "nylon", 60, 50, 2.238, fixed(0, 0, 0), fixed(SPAN, 0, 0))
    + '[events.break]\nbreaks = "BROKEN"\ntime = "5 ms"\n'
    + '[output]\nduration = "60 ms"\nevery = "2 ms"\n'
)


def rope(pull=PULL, broken="rope.end"):
    return ROPE.replace("BROKEN", broken) + target("tight", "rope", "rope.end", tension=pull)


def exact_length():
    """The length (m) that the span stretches to 180 kN: T = p1 tanh(p2 e + p3) + p4 + p5 e."""
    from scipy.optimize import brentq

    def tension(e):
        return 270.3e3 * np.tanh(10.2 * e - 2.128) + 262.7e3 + 135.5 * e

    return SPAN / (1.0 + brentq(lambda e: tension(e) - PULL, 0.05, 0.25))


@pytest.mark.parametrize("broken", ["rope.end", pytest.param("rope@20 m", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_it_parts_as_one_of_that_length(tmp_path, broken):
    found = run_text(tmp_path, rope(broken=broken))
    assert found.statuses == ["OK"]
    length = exact_length()
    alone = run_text(tmp_path, rope(broken=broken).partition("[targets")[0], f"length={length!r}")
    for name in found.lines:
        assert found.places[name][..., :] == pytest.approx(alone.places[name], rel=1e-9)
        for field in ("velocity", "tension"):
            values = alone[f"{name}.{field}"]
            assert found[f"{name}.{field}"] == pytest.approx(
                values, abs=1e-7 * np.abs(values).max()
            )
    last = list(found.lines)[-1]
    assert found.places[last][..., -1] == pytest.approx(length, rel=1e-9)


@pytest.mark.slow
def test_its_numbers_have_the_exact_ones_beside_them(tmp_path):
    (tmp_path / "scene.toml").write_text(rope())
    ran = lc.run(tmp_path / "scene.toml", {"targets.tight.tension": [90e3, PULL]})
    assert list(ran.status) == ["ok", "ok"]
    told = ran.summary("rope.end")
    assert told.static_tension.values == pytest.approx([90e3, PULL], rel=1e-9)
    assert told.peak_end_speed.values == pytest.approx(told.exact_peak_end_speed.values, rel=0.05)
    ends = ran.line("rope").unstretched_position.values[:, -1]
    assert ends[0] > ends[1] == pytest.approx(exact_length(), rel=1e-9)


@pytest.mark.slow
def test_a_derivative_goes_through_the_length(tmp_path):
    (tmp_path / "scene.toml").write_text(rope())
    speed = lc.response(
        tmp_path / "scene.toml", ["targets.tight.tension"], "last velocity at rope.end"
    )
    slope, step = float(jax.grad(speed)(speed.values)[0]), 1e-4 * PULL
    ends = [float(speed(speed.values + s * step)) for s in (1.0, -1.0)]
    assert slope == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-5)


def test_a_place_along_it_is_left_to_measures(tmp_path):
    (tmp_path / "scene.toml").write_text(rope())
    with pytest.raises(ValueError, match='expected an end of "rope", whose length a target finds'):
        lc.response(tmp_path / "scene.toml", ["targets.tight.tension"], "max velocity at rope@9 m")


@pytest.mark.slow
def test_a_moored_buoy_starts_at_rest_with_its_pretension(tmp_path):
    goal = target("tight", "left", "left.end", tension=15e3)
    ran = run_text(tmp_path, BUOY + goal + '[output]\nduration = "2 s"\nevery = "0.2 s"\n')
    assert ran.statuses == ["OK"]
    assert ran["left.end_tension"][0] == pytest.approx(15e3, rel=1e-6)
    place = ran.bodies["buoy"]["position"][0]
    assert np.abs(place - place[0]).max() < 1e-7
