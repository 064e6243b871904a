"""Runs that went wrong are drawn until then: beside what follows nothing else would be seen."""

import h5py
import numpy as np
import pytest
from synthetic_result import PRETENSIONS, TIMES, snapback

from lumpedcable.results import Coordinate, ResultWriter, Variable, open_result
from lumpedcable.results.sound import SoundFile
from lumpedcable.view import animation, figures_of, style
from lumpedcable.view.groups import alone, groups

HALF = len(TIMES) // 2
BEYOND = 1e35


@pytest.fixture(scope="module")
def blown(tmp_path_factory):
    path = snapback(tmp_path_factory.mktemp("blown") / "r.h5", segments=8, failed=(3,))
    with h5py.File(path, "r+") as file:
        for name in ("lines/rope/tension", "lines/rope/velocity", "lines/rope/position"):
            file[name][3, HALF:] = BEYOND
        for name in ("kinetic", "strain", "residual"):
            file[f"energy/{name}"][3, HALF:] = BEYOND
    return path


def test_all_is_there_until_a_run_went_wrong_and_nothing_after(blown):
    with open_result(blown) as whole:
        tension, energy = whole.line("rope").tension(), whole.energy("kinetic")
        place = whole.line("rope").position()
    with SoundFile.open(blown) as result:
        line = result.line("rope")
        for seen, kept in ((line.tension(), tension), (result.energy("kinetic"), energy)):
            assert np.isnan(seen[3, HALF:]).all()
            np.testing.assert_array_equal(seen[3, :HALF], kept[3, :HALF])
            np.testing.assert_array_equal(seen[:3], kept[:3])
        np.testing.assert_array_equal(line.position(3, 0), place[3, 0])
        assert np.isnan(line.position(3, -1)).all()
        np.testing.assert_array_equal(line.position(slice(4, 6), 7), place[4:6, 7])
        assert np.isnan(result.energy("kinetic", 3)[HALF:]).all()


def test_no_axis_reaches_beyond_what_went_well(blown):
    for name, figure in figures_of(blown).items():
        for ax in figure.axes:
            reach = np.abs([*ax.get_xlim(), *ax.get_ylim()])
            assert np.all(reach < 1e6), f"{name}: {reach}"


def test_times_reach_to_where_the_last_of_the_runs_shown_went_wrong(blown):
    with SoundFile.open(blown) as result:
        assert alone(result, 3).clock(result, TIMES).last == HALF
        (together,) = (g for g in groups(result) if 3 in g.runs)
        assert together.clock(result, TIMES).last == len(TIMES) - 1
    # at least two times, and no more than there are
    assert [style.clock(TIMES, until).last for until in (0.0, TIMES[-1], 1e9)] == [
        1,
        *[len(TIMES) - 1] * 2,
    ]


def test_a_film_ends_where_the_run_went_wrong(blown):
    with SoundFile.open(blown) as result, style.styled():
        film = animation._Film(result, 3, 10.0, ({}, (), (), None))
        assert film.times[-1] == TIMES[HALF - 1]
        assert film.bottom.get_ylim()[1] < 2e-3 * PRETENSIONS[-1]


def test_bodies_that_fly_off_or_stop_leave_the_others_on_their_scale(tmp_path):
    times, path = np.linspace(0.0, 4.0, 5), tmp_path / "r.h5"
    position = np.zeros((4, 5, 3))
    position[:, :, 0] = times
    position[1, 3:] = BEYOND
    position[2, 4:, 0] = 4.5
    position[3, 3:, 0] = 2.5  # where it stopped
    meanings = {"flag_values": np.array([0, 4, 9], "i1")}
    meanings["flag_meanings"] = "ok line_reversed still_moving"
    shape = ("run", "time", "xyz")
    variables = [
        Variable("bodies/ship/position", shape, "f8", "m"),
        Variable("bodies/ship/velocity", shape, "f8", "m/s"),
        Variable("status", ("run",), "i1", "1", "outcome", meanings),
        Variable("status_time", ("run",), "f8", "s"),
        Variable("summary/stop_time", ("run",), "f8", "s"),
    ]
    dims = {"run": 4, "time": 5, "xyz": 3}
    known = {"time": Coordinate(times, "s")}
    with ResultWriter(
        path, dims=dims, variables=variables, coordinates=known, attributes={}
    ) as writer:
        writer.write("bodies/ship/position", position)
        writer.write("bodies/ship/velocity", 0.0 * position)
        writer.write("status", [0, 4, 9, 0])
        writer.write("status_time", [np.nan, 3.0, 4.0, np.nan])
        writer.write("summary/stop_time", [np.nan, np.nan, np.nan, 2.6])
        writer.finish()
    with SoundFile.open(path) as result:  # the axis ends with the output that is of the stop
        assert alone(result, 3).clock(result, times).last == 3
    far, _ = figures_of(path)["body_ship"].axes
    whole, failed, moving, stopped = (line.get_ydata() for line in far.lines)
    np.testing.assert_allclose(whole, times)
    np.testing.assert_allclose(failed, [0.0, 1.0, 2.0, np.nan, np.nan])
    # one that has not stopped yet has not gone wrong
    np.testing.assert_allclose(moving, [0.0, 1.0, 2.0, 3.0, 4.5])
    # and of one that has, only the stop itself is shown
    np.testing.assert_allclose(stopped, [0.0, 1.0, 2.0, 2.5, np.nan])
    assert far.get_ylim()[1] < 5.0
