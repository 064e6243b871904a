"""Bending moments: in balance with the loads, those of beams and of the elastica, in places and cuts."""

import h5py
import numpy as np
import pytest
from engine_runs import order_of, run_text
from scipy.integrate import solve_bvp

from lumpedcable.export import export_result
from lumpedcable.results import ResultError, open_result

GRAVITY, LENGTH, EI = 9.81, 2.0, 100.0


def rod(*, mass=0.5, EA=1e7, segments=20, start=None, end='"free"', more="", scene="", output=""):
    start = start or "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"
    return f"""
gravity = {GRAVITY}
[materials.steel]
law = "linear"
EA = {EA}
[lines.rod]
material = "steel"
length = {LENGTH}
segments = {segments}
mass = {mass}
bending = {{ EI = {EI} }}
start = {start}
end = {end}
{more}
{scene}
[output]
{output}
"""


RESTING = 'quantities = ["position", "bending_moment"]'


def at_rest(folder, text):
    """Positions (m) of the nodes, (nodes, 3), and moments (N m) there."""
    found = run_text(folder, text)
    assert found.statuses == ["OK"]
    return found["position"][0, 0], found["bending_moment"][0, 0]


def weights(position, mass):
    """Weight (N) that stands at each node: half of each segment next to it."""
    half = np.full(len(position), LENGTH / (len(position) - 1))
    half[[0, -1]] /= 2.0
    return half * mass * GRAVITY


@pytest.mark.parametrize(
    "direction", [pytest.param((0.0, 0.0, -1.0), marks=pytest.mark.slow), (0.3, 0.8, -0.52)]
)
@pytest.mark.slow
def test_moments_are_in_balance_with_all_that_pulls_beyond_them(tmp_path, direction):
    way = np.array(direction) / np.linalg.norm(direction)
    end = f"{{ held = {{ pretension = 40.0, direction = {way.tolist()} }} }}"
    place, moment = at_rest(tmp_path, rod(end=end, output=RESTING))
    forces = np.zeros_like(place)
    forces[:, 2] = -weights(place, 0.5)
    forces[-1] += 40.0 * way
    couples = [
        np.linalg.norm(np.cross(place[k:] - place[k], forces[k:]).sum(axis=0))
        for k in range(len(place))
    ]
    assert couples[0] > 60.0  # of some 80 N m of a straight rod: it bends far
    np.testing.assert_allclose(moment, couples, atol=1e-6)
    assert moment[-1] == 0.0


@pytest.mark.slow
def test_moments_tend_to_those_of_the_elastica_with_the_second_order(tmp_path):
    force = 80.0

    def bends(s, y):  # angle below the wall's way and EI times its rate
        return np.stack([y[1] / EI, -force * np.cos(y[0])])

    def held(a, b):
        return np.array([a[0], b[1]])

    places = np.linspace(0.0, LENGTH, 200)
    guess = np.stack([0.8 * places / LENGTH, force * (LENGTH - places)])
    exact = solve_bvp(bends, held, places, guess, tol=1e-10)
    assert exact.success
    end = f"{{ held = {{ pretension = {force}, direction = [0, 0, -1] }} }}"
    errors = []
    for segments in (10, 20, 40):
        text = rod(mass=1e-9, segments=segments, end=end, output=RESTING)
        _, moment = at_rest(tmp_path, text)
        wanted = exact.sol(np.linspace(0.0, LENGTH, segments + 1))[1]
        errors.append(np.abs(moment - wanted).max() / wanted[0])
    assert errors[-1] < 3e-4  # a third of (l / L)^2
    assert np.all(np.abs(order_of(errors, 2.0) - 2.0) < 0.15)


MOVING = 'duration = "60 ms"\nevery = "2 ms"\nquantities = ["position", "bending_moment"]'
LIGHT = {"mass": 0.05, "EA": 1e5}  # it swings once in 160 ms
LET_GO = '[events.tip]\nbreaks = "rod.end"\ntime = "5 ms"\n'
BENT = "{ held = { pretension = 20, direction = [0, 0.6, -0.8] } }"


@pytest.mark.slow
def test_moments_of_a_moving_rod_are_EI_times_the_curvature_of_its_shape(tmp_path):
    found = run_text(tmp_path, rod(**LIGHT, end=BENT, scene=LET_GO, output=MOVING))
    assert found.statuses == ["OK"]
    place, moment = found["position"][0], found["bending_moment"][0]
    assert np.ptp(moment[:, 0]) > 30.0  # of some 45 N m
    # the circle through three neighbours: 1/R = 4 A / (a b c)
    before, here, after = place[:, :-2], place[:, 1:-1], place[:, 2:]
    sides = [np.linalg.norm(x, axis=-1) for x in (here - before, after - here, after - before)]
    area = 0.5 * np.linalg.norm(np.cross(here - before, after - here), axis=-1)
    curvature = 4.0 * area / np.prod(sides, axis=0)
    np.testing.assert_allclose(moment[:, 1:-1], EI * curvature, rtol=2e-3, atol=1e-6)


@pytest.mark.slow
def test_both_parts_have_the_moment_at_a_cut_until_the_line_breaks_there(tmp_path):
    plain = '[solver]\nwaves = "plain"\ncourant = 0.5\n'  # fronts know of joints
    whole = run_text(tmp_path, rod(**LIGHT, end=BENT, scene=LET_GO + plain, output=MOVING))
    cut = '[events.cut]\nbreaks = "rod@0.8 m"\ntime = "4 ms"\nstart = "30.1 ms"\n'
    parts = run_text(tmp_path, rod(**LIGHT, end=BENT, scene=LET_GO + cut + plain, output=MOVING))
    one, first, last = (
        found["bending_moment" if name is None else f"{name}.bending_moment"][0]
        for found, name in ((whole, None), (parts, "rod-1"), (parts, "rod-2"))
    )
    held, gone = whole.time <= 0.03, whole.time > 0.0342
    np.testing.assert_allclose(first[held], one[held, :9], rtol=1e-6)
    np.testing.assert_allclose(last[held], one[held, 8:], rtol=1e-6, atol=1e-6)
    assert np.all(first[gone, -1] == 0.0)
    assert np.all(last[gone, 0] == 0.0)


def test_a_measure_of_a_place_is_linear_between_nodes_and_has_a_limit(tmp_path):
    asked = """
[measures.wall]
bending_moment = "rod.start"
limit = "10 N m"
[measures.aside]
bending_moment = "rod@0.73 m"
"""
    text = rod(**LIGHT, end=BENT, scene=LET_GO + asked, output=MOVING)
    found = run_text(tmp_path, text)
    moment = found["bending_moment"][0]
    places = np.linspace(0.0, LENGTH, 21)
    with open_result(tmp_path / "result.h5") as result:
        measures, summary = result.measures(), result.summary()["run"]
        told = result.summary_attributes("run", "wall")
    table, attributes = measures["aside"]
    assert attributes["units"] == told["units"] == "N m"
    assert told["limit"] == 10.0
    aside = [np.interp(0.73, places, row) for row in moment]
    np.testing.assert_allclose(table[0], aside, rtol=1e-12)
    np.testing.assert_allclose(measures["wall"][0][0], moment[:, 0], rtol=1e-12)
    assert summary["wall"][0] == moment[:, 0].max()
    assert "wall" in found.outcomes[0].message or summary["wall"][0] > 10.0


BESIDE = """
[lines.chain]
material = "steel"
length = 1.0
segments = 4
mass = 1.0
start = { fixed = [0, 0, -1] }
end = "free"
"""


@pytest.mark.slow
def test_lines_without_bending_have_none_and_a_straight_rod_bears_none(tmp_path):
    found = run_text(tmp_path, rod(scene=BESIDE, output=RESTING))
    assert "bending_moment" in found.lines["rod"]
    assert "bending_moment" not in found.lines["chain"]
    text = rod(start="{ fixed = [0, 0, 0] }", output=MOVING)
    text = text.replace("gravity = 9.81", "")
    straight = run_text(tmp_path, text, "lines.rod.end={held={pretension=1, direction=[1, 0, 0]}}")
    assert straight["position"].shape == (1, 31, 21, 3)
    assert np.all(straight["bending_moment"] == 0.0)
    assert straight["bending_moment"].shape == (1, 31, 21)


def test_it_is_kept_unless_others_are_asked_for(tmp_path):
    found = run_text(tmp_path, rod(output=""))
    assert {"position", "bending_moment", "strain"} <= found.lines["rod"].keys()
    run_text(tmp_path, rod(output='quantities = ["position"]'))
    with open_result(tmp_path / "result.h5") as result, pytest.raises(ResultError, match="no bend"):
        result.line("rod").field("bending_moment")


@pytest.mark.slow
def test_of_finer_and_coarser_runs_all_are_kept(tmp_path):
    sweep = '[sweep]\n"lines.rod.segments" = [6, 10]\n'
    found = run_text(tmp_path, rod(scene=sweep, output=RESTING))
    moment = found["bending_moment"][:, 0]
    assert np.isfinite(moment).sum(axis=1).tolist() == [7, 11]
    # w L^2 / 2 less what the turning takes
    np.testing.assert_allclose(moment[:, 0], 0.5 * 9.81 * LENGTH**2 / 2.0, rtol=0.01)


@pytest.mark.slow
def test_an_exported_grid_has_them_and_nan_along_other_lines(tmp_path):
    found = run_text(tmp_path, rod(scene=BESIDE, segments=6, output=RESTING))
    export_result(tmp_path / "result.h5", "vtkhdf", tmp_path / "bent.vtkhdf", 0)
    with h5py.File(tmp_path / "bent.vtkhdf") as grid:
        moment = grid["VTKHDF/PointData/bending_moment"][()]
    # the rod's seven nodes come before the chain's five, as in the scene
    assert np.isnan(moment[7:]).all()
    np.testing.assert_allclose(moment[:7], found["rod.bending_moment"][0, 0], rtol=1e-6)
