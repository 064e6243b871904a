"""Every scene of configs/hard/ ends as its first lines say: status, exact value, energy."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, scene_of

from benchmarks import hard_exact as exact
from benchmarks.hard import is_stable, table, written
from benchmarks.hard_cases import CASES, FOLDER, momentum, run_case
from lumpedcable.status import Status

CASE = {case.name: case for case in CASES}


def ran(name, segments, *changes):
    return run_case(name, *CASE[name].sized(segments), *changes)


def test_every_scene_is_a_case_and_says_what_is_expected():
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(CASE)
    for path in FOLDER.glob("*.toml"):
        head = path.read_text().partition("title =")[0]
        assert "# Expected" in head, path.name


def close(found, name, tolerance):
    """All measured values of a case within a relative tolerance of the exact ones."""
    case = CASE[name]
    values, right = case.measure(found), case.exact()
    assert found.outcome.status is case.status
    for key, value in right.items():
        assert values[key] == pytest.approx(value, rel=tolerance), key
    return values


# --- a break in no time, and what comes of it ---------------------------------------------------


def arrives(found, segments):
    """How many segments too early the shock is at the wall."""
    right = CASE["break-at-once"].exact()["front arrival, ms"]
    early = right - 1e3 * found.outcome.recoils["rope.end"]["front_arrival"]
    return early * 1026.893e-3 / (60.0 / segments)


def test_a_break_in_no_time():
    found = ran("break-at-once", 100)
    # the end starts with an overshoot that decays over the first segments, a few of a hundred
    values = close(found, "break-at-once", 0.03)
    right = CASE["break-at-once"].exact()["end speed, m/s"]
    assert values["end speed, m/s"] == pytest.approx(right, rel=5e-3)
    # a limited viscosity spreads a shock over two or three segments
    assert 0.0 < arrives(found, 100) < 3.0
    # second order in the step where it is smooth, and a shock is not
    assert found.outcome.energy_closure < 2e-3


@pytest.mark.slow
def test_a_break_in_no_time_up_to_6400_segments():
    right = CASE["break-at-once"].exact()["end speed, m/s"]
    # the error of the mean speed is parts in ten thousand from the first mesh on, and changes its sign
    for segments in (50, 100, 200, 400, 800, 1600, 3200, 6400):
        found = ran("break-at-once", segments)
        assert found.outcome.status is Status.OK
        error = abs(CASE["break-at-once"].measure(found)["end speed, m/s"] / right - 1.0)
        assert error < 1e-3
        assert 0.0 < arrives(found, segments) < 3.0
    assert error < 1e-4


def reversed_after(segments):
    """How long after the shock is at the wall the line has reversed (s), and that it is told."""
    first, last = exact.pile_up_bounds()
    outcome = ran("pile-up", segments).outcome
    assert outcome.status is Status.LINE_REVERSED
    assert first < outcome.status_time < last
    assert "mesh" in outcome.message
    numbers = outcome.recoils["rope.end"]
    assert np.isnan(numbers["end_displacement"])
    assert numbers["front_arrival"] < outcome.status_time
    assert outcome.energy_closure < 2e-3  # until then
    return outcome.status_time - first


def test_a_pile_up_is_told():
    reversed_after(100)


@pytest.mark.slow
def test_a_pile_up_comes_to_the_exact_time():
    # exact: at once; the chain needs the time in which its first segment is passed. From 50 to 1600
    # segments that is 32 times shorter
    assert reversed_after(1600) < 0.25 * reversed_after(50)


# --- snapping taut ------------------------------------------------------------------------------


@pytest.mark.parametrize("segments", [pytest.param(100, marks=pytest.mark.slow), 400])
def test_a_slack_line_snaps_taut(segments):
    # the plateaus of the exact waves; the lumps behind a shock go on jostling a little
    found = ran("snap", segments)
    close(found, "snap", 5e-3)
    assert found.outcome.energy_closure < 5e-3
    if segments == 400:
        snaps_no_harder(found)


def snaps_no_harder(found):
    # steps of 0.9 of the bound, near which viscosity has no room, peak at 8705 N: 2 % too high
    right = CASE["snap"].exact()["peak, N"]
    assert CASE["snap"].measure(found)["peak, N"] == pytest.approx(right, rel=2e-3)
    assert found.outcome.energy_closure < 2e-3


@pytest.mark.slow
def test_the_snap_load_converges():
    # the mean loads are those of the exact waves to 0.1 % from 100 segments on
    for segments in (100, 200, 400):
        found = ran("snap", segments)
        values, right = CASE["snap"].measure(found), CASE["snap"].exact()
        for key in ("load in the middle, N", "load at the ends, N"):
            assert values[key] == pytest.approx(right[key], rel=1e-3)


@pytest.mark.slow
def test_a_chain_without_viscosity_snaps_too_hard():
    # every lump that is picked up rings on: the peak is half as high again as the exact one
    found = ran("snap", 100, "solver.waves=plain", "solver.courant=0.3")
    assert CASE["snap"].measure(found)["peak, N"] > 1.4 * CASE["snap"].exact()["peak, N"]


def test_the_exact_snap_conserves_momentum_and_length():
    loads = exact.snap_loads()
    c, half = 1000.0, 25.0
    meet = half / loads["shock"]
    # by then the pull on one half has set all of it moving at 2.5 m/s
    assert loads["first"] * meet == pytest.approx(half * 2.5)
    # at the third front the line is evenly stretched: its length is that of its ends
    when = meet + half / c
    assert 1e6 * (5.0 * when / 50.0 - 0.005) == pytest.approx(loads["middle"])


# --- stiff beside soft, coarse beside fine -------------------------------------------------------


def alone(folder, name, step):
    """The history of the end of one of the two lines without the other (m)."""
    other = "soft" if name == "stiff" else "stiff"
    changes = [f"lines.{name}.segments=20", f"solver.step={step!r}"]
    path = folder / f"{name}.toml"
    path.write_text(without(FOLDER / "stiff-and-soft.toml", f"lines.{other}", f"events.{other}"))
    return run_case(path, *changes).fields[f"{name}.position"][:, -1, 0]


def without(path, *tables):
    """The text of a scene without some of its tables."""
    blocks = path.read_text().split("\n[")
    return "\n[".join(b for b in blocks if b.partition("]")[0] not in tables)


@pytest.mark.slow
def test_a_stiff_line_beside_a_soft_one():
    found = ran("stiff-and-soft", 20)
    assert found.outcome.status is Status.OK
    values = CASE["stiff-and-soft"].measure(found)
    # waves of 50 m and 10 m length in segments of 1 m: dispersion is (k l)^2 / 24 with k = 2 pi / 10 m
    assert values["stiff history, % off"] < 0.1
    assert values["soft history, % off"] < 1.6
    assert found.outcome.energy_closure < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stiff", "soft"])
def test_a_line_does_not_feel_the_other(tmp_path, name):
    found = ran("stiff-and-soft", 20)
    both = found.fields[f"{name}.position"][:, -1, 0]
    single = alone(tmp_path, name, found.outcome.solver_step)
    # statics ends at 1e-10, and the limiter of the viscosity makes more of the difference
    size = np.max(np.abs(both - both[0]))
    np.testing.assert_allclose(single, both, rtol=0, atol=1e-6 * size)


def graded_error(segments):
    """Error of the history of the graded line (%)."""
    found = ran("graded", segments)
    assert found.outcome.status is Status.OK
    assert found.outcome.energy_closure < 1e-4
    return CASE["graded"].measure(found)["history, % off"]


def test_segments_a_hundred_to_one():
    # the coarsest segment is 9.15 m: reflections that come a fifth of one too early or too late move
    # the end, at 100 m/s to and fro, by 2 % of its 10 m
    assert graded_error(50) < 2.0


@pytest.mark.slow
def test_a_graded_line_to_second_order():
    errors = [graded_error(segments) for segments in (50, 100, 200)]
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.35 * errors[1]


# --- breaks elsewhere and later -------------------------------------------------------------------


@pytest.mark.slow
def test_a_break_in_the_middle():
    found = ran("mid-break", 80)
    # 5 ms are five segments long: arrivals within one of them, speeds to the square of a fifth of it
    close(found, "mid-break", 0.04)
    values, right = CASE["mid-break"].measure(found), CASE["mid-break"].exact()
    assert values["left end, m/s"] == pytest.approx(right["left end, m/s"], rel=2e-3)
    assert found.outcome.energy_closure < 2e-3
    left, right = found.fields["rope-1.velocity"], found.fields["rope-2.velocity"]
    # mirror images, until the nearer wall is felt in the shorter piece
    early = found.time < 20e-3
    mirrored = -right[early, ::-1, 0][:, -20:]
    np.testing.assert_allclose(left[early, -20:, 0], mirrored, rtol=0, atol=1e-6 * 111.0)


@pytest.mark.slow
def test_a_piece_is_a_line_that_breaks_at_its_end():
    halves = ran("mid-break", 80)
    whole = run_case(
        "mid-break", "rope.length=37.5 m", "rope.segments=50", "events.break={breaks='rope.end',"
        " time='5 ms'}", "rope.end.fixed=[44.1611167125 m, 0, 0]",
        f"solver.step={halves.outcome.solver_step!r}",
    )  # fmt: skip
    a, b = whole.fields["rope.velocity"][:, :, 0], halves.fields["rope-1.velocity"][:, :, 0]
    # the limiter of the viscosity makes more of differences of rounding
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * 111.0)


@pytest.mark.slow
def test_a_break_while_the_line_still_rings():
    found = ran("ringing", 100)
    close(found, "ringing", 1e-3)
    right = exact.rung(found.time)
    # on the plateaus, 20 ms after every kink: ripples of a few per cent of 50 m/s
    steady = np.ones(found.time.shape, bool)
    for k in range(6):
        steady &= (found.time < 0.1 * k - 5e-3) | (found.time > 0.1 * k + 30e-3)
        steady &= (found.time < 0.05 + 0.1 * k - 5e-3) | (found.time > 0.08 + 0.1 * k)
    assert steady.sum() > 30
    for node, velocity in ((0, right.start), (-1, right.end)):
        v = found.fields["rope.velocity"][:, node, 0]
        np.testing.assert_allclose(v[steady], velocity[steady], rtol=0, atol=0.02 * 50.0)
    pushed = momentum(found, "rope", 1.0, np.full(100, 1.0))
    np.testing.assert_allclose(pushed, right.momentum, rtol=0, atol=0.01 * 2500.0)
    assert found.outcome.energy_closure < 2e-3
    # the second break begins under a tension that is not the one at rest: no exact wave is claimed
    second = found.outcome.recoils["rope.start"]
    assert np.isnan(second["exact_peak_end_speed"])
    assert np.isnan(second["front_arrival"])


# --- laws, precision, water, bending --------------------------------------------------------------


@pytest.mark.slow
def test_a_law_with_a_dead_band():
    found = ran("dead-band", 100)
    close(found, "dead-band", 0.01)
    # the slack end coasts: nothing there holds anything, and nothing has compressed it
    strain = found.fields["rope.strain"]
    assert np.min(strain) > 0.0
    assert np.all(found.fields["rope.tension"][-1, -5:] < 60.0)  # a thousandth of 60 kN
    assert found.outcome.energy_closure < 2e-3


@pytest.mark.slow
def test_single_precision_with_1600_segments():
    found = ran("single-precision", 1600)
    # a millisecond is thirty segments long: speed and arrival to (1/30)^2 of themselves and less
    close(found, "single-precision", 1e-4)
    assert found.outcome.energy_closure < 1e-4


@pytest.mark.slow
def test_single_precision_against_double():
    single = ran("single-precision", 1600)
    double = ran("single-precision", 1600, "solver.dtype=float64")
    close(double, "single-precision", 1e-4)
    # 2040 steps, each rounded to 1e-7 of what has been moved: at worst they add up like their number
    worst = single.outcome.steps * np.finfo(np.float32).eps
    for key, size in (("position", 6.4), ("velocity", 111.2)):
        off = np.max(np.abs(single.fields[f"rope.{key}"] - double.fields[f"rope.{key}"]))
        assert off < worst * size, key


@pytest.mark.slow
def test_a_light_line_in_a_strong_current():
    found = ran("light-in-current", 50, "output.duration=45 s")
    values, right = CASE["light-in-current"].measure(found), CASE["light-in-current"].exact()
    # a polygon of 50 sides in the curve: (1/50)^2 of the tension
    assert values["held, anchor, N"] == pytest.approx(right["held, anchor, N"], rel=1 / 50**2)
    # it stays there: an unstable shape would leave it within the second before the break
    still = found.fields["rope.velocity"][found.time < 1.0]
    assert np.max(np.abs(still)) < 1e-3
    # straight in the end, where a chain of lumps is exact; it has 44 s to get there. The
    # dispersion correction knows the load at the anchored node as it was at rest, and not this one: it
    # may move the tension by a twelfth of a segment's load
    assert values["free, angle, deg"] == pytest.approx(right["free, angle, deg"], rel=1e-4)
    assert values["free, anchor, N"] == pytest.approx(right["free, anchor, N"], rel=1 / 50 / 12)
    assert found.outcome.status is Status.OK
    assert found.outcome.energy_closure < 2e-3


def test_a_light_line_with_a_free_end_finds_its_place(tmp_path):
    # 800 segments hung up in a current that folds them: Newton's method never came out of that
    text = without(FOLDER / "light-in-current.toml", "events.break")
    text = text.replace('end = { fixed = [0, 0, "40 m"] }', 'end = "free"')
    found, coordinates = equilibrium_of(scene_of(tmp_path, text, "rope.segments=800"))
    assert bool(found.converged)
    x, _, z = nodes_in_space(found, coordinates)
    angle, anchor = exact.trailing()
    np.testing.assert_allclose(np.arctan2(z[1:], x[1:]), angle, rtol=0, atol=1e-6)
    # a segment carries the load of what is beyond its middle
    first = float(found.model.lines["rope"].reference_strain[0])
    assert first * 1e6 == pytest.approx(anchor * (1.0 - 0.5 / 800), rel=1e-6)


def rod_error(segments):
    """Error of the rod's history (%), and that it ended well."""
    found = ran("stiff-bending", segments)
    assert found.outcome.status is Status.OK
    assert found.outcome.energy_closure < 1e-4
    values = CASE["stiff-bending"].measure(found)
    # the bend at the clamp is half a segment's: (1/N)^2
    assert values["tip at rest, mm"] == pytest.approx(100.0, rel=1 / segments**2)
    return values["tip history, % off"]


@pytest.mark.slow
def test_a_stiff_rod_without_tension():
    # frequencies are right to some (1/N)^2, and in 4 s the first mode turns by 14 rad
    assert rod_error(20) < 100.0 * 14.0 * 2.0 / 20**2


@pytest.mark.slow
def test_a_stiff_rod_to_second_order():
    errors = [rod_error(segments) for segments in (20, 40, 80)]
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.35 * errors[1]


def test_the_exact_rod_starts_bent_and_returns():
    # the series at t = 0 is the deflection of a cantilever, P L^3 / (3 EI) = 0.1 m
    assert exact.rod_tip(np.zeros(1))[0] == pytest.approx(0.1, rel=1e-6)


# --- the report -----------------------------------------------------------------------------------


def test_an_unstable_step_is_seen():
    case = CASE["graded"]
    short = (*case.sized(50), "output.duration=60 ms")
    good = run_case("graded", *short)
    assert is_stable(case, good, good.top_speed())
    beyond = 1.2 * good.outcome.solver_step / 0.9
    over = run_case("graded", *short, f"solver.step={beyond!r}")
    assert not is_stable(case, over, good.top_speed())


def test_the_page_takes_the_table():
    run = {
        "segments": 100, "status": "OK", "expected": "OK", "values": {"a, N": 1.1},
        "energy_residual": 1e-3, "steps": 5, "seconds": 0.1, "stable_courant": float("nan"),
    }  # fmt: skip
    runs = [run, *(run | {"segments": n, "stable_courant": found}
                   for n, found in ((200, 0.871), (400, 0.99), (800, None)))]  # fmt: skip
    case = {"title": "x", "segments": 100, "exact": {"a, N": 1.0}, "runs": runs}
    data = {"machine": {"device": "d", "system": "s"}, "cases": {"x": case}}
    assert "1.1 (+10 %)" in table(data)
    steps = table(data).partition("largest stable")[2].splitlines()[2:]
    assert [row.split(" | ")[4] for row in steps] == ["below 0.5", "0.87", "0.99 (all)", ""]
    assert written("a\n<!-- hard cases -->old<!-- end -->\nb", data).count(table(data)) == 1
    with pytest.raises(ValueError, match="one place"):
        written("no markers", data)
