"""Bending moments along lines, drawn from closed forms."""

import numpy as np
from synthetic_result import ATTRIBUTES

from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.view.groups import MOST_PANELS
from lumpedcable.view.plot import figures_of

NODE = np.linspace(0.0, 10.0, 21)
CANTILEVER = 982.0 * (NODE[-1] - NODE) ** 2 / 2  # N m under 982 N/m


def written(path, moments):
    """A file of lines with moments (N m) by name, (run, time, node); the first run went well."""
    runs, times, _ = next(iter(moments.values())).shape
    dims, places = {"run": runs, "time": times}, {}
    meanings = {"flag_values": np.array([0, 1, 2], "i1"), "flag_meanings": "pending ok diverged"}
    variables = [
        Variable("status", ("run",), "i1", "1", "outcome", meanings),
        Variable("status_time", ("run",), "f8", "s"),
    ]
    for name in moments:
        dims[f"lines/{name}/node"] = len(NODE)
        dims_of = ("run", "time", "node")
        variables.append(Variable(f"lines/{name}/bending_moment", dims_of, "f8", "N m"))
        places[f"lines/{name}/unstretched_position"] = Coordinate(NODE, "m", "", ("node",))
    time = Coordinate(np.arange(times) * 1.0, "s")
    coordinates = {"time": time, **places}
    with ResultWriter(
        path, dims=dims, variables=variables, coordinates=coordinates, attributes=ATTRIBUTES
    ) as writer:
        for name, values in moments.items():
            writer.write(f"lines/{name}/bending_moment", values)
        writer.write("status", np.array([1] + [2] * (runs - 1), "i1"))
        writer.write("status_time", np.array([np.nan] + [1.0] * (runs - 1)))
        writer.finish()
    return path


def test_a_run_shows_its_largest_moments_and_those_at_the_start(tmp_path):
    moments = CANTILEVER * np.array([1.0, 1.5, 0.2])[:, None]
    figure = figures_of(written(tmp_path / "a.h5", {"beam": moments[None]}))["bending_moment"]
    (ax,) = figure.axes
    most, start = ax.lines
    for line, share in ((most, 1.5), (start, 1.0)):
        np.testing.assert_allclose(line.get_xdata(), NODE)
        np.testing.assert_allclose(line.get_ydata(), share * CANTILEVER / 1e3, rtol=1e-5)
    assert ax.get_title() == "beam: at most 73.65 kN m, at 0 m"
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "unstretched position (m)",
        "bending moment (kN m)",
    )
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["largest", "at the start"]


def test_a_beam_at_rest_has_one_curve(tmp_path):
    path = written(tmp_path / "a.h5", {"beam": CANTILEVER[None, None]})
    (ax,) = figures_of(path)["bending_moment"].axes
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), CANTILEVER / 1e3, rtol=1e-5)


def test_of_several_runs_each_has_a_curve_that_ends_where_it_went_wrong(tmp_path):
    moments = np.stack(
        [np.outer([1.0, 2.0, 3.0], CANTILEVER), np.outer([1.0, 2.0, 9.0], CANTILEVER)]
    )
    (ax,) = figures_of(written(tmp_path / "a.h5", {"beam": moments}))["bending_moment"].axes
    peaks = [line.get_ydata()[0] / CANTILEVER[0] * 1e3 for line in ax.lines]
    np.testing.assert_allclose(peaks, [3.0, 1.0], rtol=1e-5)


def test_of_many_lines_those_that_bear_the_most_are_shown(tmp_path):
    many = {f"l{k:02}": (k + 1.0) * CANTILEVER[None, None] for k in range(MOST_PANELS + 2)}
    figure = figures_of(written(tmp_path / "a.h5", many))["bending_moment"]
    names = [ax.get_title().split(":")[0] for ax in figure.axes]
    assert names == [f"l{k:02}" for k in range(2, MOST_PANELS + 2)]
    assert f"The {MOST_PANELS} of {len(many)} lines that bear the most." in figure.get_supxlabel()
