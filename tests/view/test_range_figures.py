"""The range of the tension along lines: against closed forms, of any step, of several lines and runs."""

import numpy as np
import pytest
from synthetic_result import TIMES, snapback, wave

from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.view.groups import MOST_PANELS
from lumpedcable.view.plot import figures_of

ALONG = ("run", "time", "segment")
EACH = ("run", "segment")


def lines(path, tensions, peaks=None, status=(1,), strength=None):
    """A file of lines of 10 m with tensions (N) by name, (run, time, segment), and what they bore.

    `strength` is that of all lines in each run (N).
    """
    times = next(iter(tensions.values())).shape[1]
    dims, places = {"run": len(status), "time": times}, {}
    meanings = {"flag_values": np.array([0, 1, 2], "i1"), "flag_meanings": "pending ok diverged"}
    variables = [
        Variable("status", ("run",), "i1", "1", "outcome", meanings),
        Variable("status_time", ("run",), "f8", "s"),
    ]
    for name, values in tensions.items():
        segments = values.shape[2]
        dims |= {f"lines/{name}/node": segments + 1, f"lines/{name}/segment": segments}
        variables.append(Variable(f"lines/{name}/tension", ALONG, "f8", "N"))
        if peaks:
            variables.append(Variable(f"lines/{name}/peak_tension", EACH, "f8", "N"))
        node = np.linspace(0, 10, segments + 1)
        for what, at in (("position", node), ("segment", (node[1:] + node[:-1]) / 2)):
            dim = "node" if what == "position" else "segment"
            places[f"lines/{name}/unstretched_{what}"] = Coordinate(at, "m", "", (dim,))
        if strength:
            places[f"lines/{name}/breaking_strength"] = Coordinate(strength, "N", "", ("run",))
    with ResultWriter(
        path,
        dims=dims,
        variables=variables,
        coordinates={"time": Coordinate(np.arange(times) * 1.0, "s"), **places},
    ) as writer:
        for name, values in tensions.items():
            writer.write(f"lines/{name}/tension", values)
            if peaks:
                writer.write(f"lines/{name}/peak_tension", peaks[name])
        writer.write("status", np.array(status, "i1"))
        writer.write("status_time", np.where(np.array(status) == 1, np.nan, 1.0))
        writer.finish()
    return path


def curves(ax):
    return [(line.get_xdata().tolist(), line.get_ydata().tolist()) for line in ax.lines]


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_range_is_that_of_the_exact_wave(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), broken=False, segments=20, swept=False,
                    break_times=(5e-3,), padded=3)  # fmt: skip
    figure = figures_of(path)["tension_range"]
    (ax,) = figure.axes
    middles = np.arange(1.5, 60, 3)
    exact, _ = wave(middles, TIMES, 45e3, 5e-3)
    place = [0, *middles, 60]
    for drawn, values in zip(
        ax.lines, [exact.max(axis=0), exact.min(axis=0), exact[0]], strict=True
    ):
        np.testing.assert_allclose(drawn.get_xdata(), place)
        np.testing.assert_allclose(
            drawn.get_ydata(), np.array([values[0], *values, values[-1]]) / 1e3, atol=1e-4
        )
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("unstretched position (m)", "tension (kN)")
    assert legend(figure) == ["largest", "smallest at the saved times", "at the start"]
    assert figure.legends[0].get_title().get_text().startswith(
        "Largest tension of each segment at the saved times."
    )  # fmt: skip


def test_what_was_borne_between_the_saved_times_counts(tmp_path):
    saved = np.array([[[1e3, 2e3], [3e3, 1e3]]])
    path = lines(tmp_path / "a.h5", {"rope": saved}, {"rope": np.array([[4e3, 9e3]])})
    figure = figures_of(path)["tension_range"]
    (ax,) = figure.axes
    place = [0, 2.5, 7.5, 10]
    assert curves(ax) == [
        (place, [4, 4, 9, 9]),
        (place, [1, 1, 1, 1]),
        (place, [1, 1, 2, 2]),
    ]
    assert ax.get_title() == "rope: at most 9 kN, at 7.5 m"
    assert figure.legends[0].get_title().get_text() == (
        "Largest tension of each segment at any step."
    )


def test_of_several_runs_the_largest_and_of_a_failed_one_that_until_then(tmp_path):
    saved = np.array([[[1e3], [2e3]], [[5e3], [1e9]]])
    peaks = {"rope": np.array([[3e3], [np.nan]])}
    path = lines(tmp_path / "a.h5", {"rope": saved}, peaks, status=(1, 2))
    figure = figures_of(path)["tension_range"]
    (ax,) = figure.axes
    # a single segment bears the same from end to end
    assert curves(ax) == [([0, 5, 10], [3, 3, 3]), ([0, 5, 10], [5, 5, 5])]
    note = figure.legends[0].get_title().get_text().replace("\n", " ")
    assert note == (
        "Largest tension of each segment at any step, of runs that went wrong at the saved times"
        " until then."
    )


@pytest.mark.parametrize("count", [2, MOST_PANELS + 2])
def test_a_panel_for_each_line_or_for_those_that_bear_the_most(tmp_path, count):
    found = {f"l{k:02}": np.full((1, 2, 2), 1e3 * (1 + k)) for k in range(count)}
    figure = figures_of(lines(tmp_path / "a.h5", found))["tension_range"]
    names = [ax.get_title().split(":")[0] for ax in figure.axes]
    assert names == list(found)[-MOST_PANELS:]
    note = figure.legends[0].get_title().get_text()
    assert (f"{MOST_PANELS} of {count} lines" in note) == (count > MOST_PANELS)


def test_a_strength_is_drawn_beside_the_tensions(tmp_path):
    saved = np.array([[[1e3, 2e3], [3e3, 1e3]]])
    figure = figures_of(lines(tmp_path / "a.h5", {"rope": saved}, strength=[9e3]))["tension_range"]
    (ax,) = figure.axes
    assert list(ax.lines[-1].get_xdata()) == [0, 1]  # across the whole axis
    assert list(ax.lines[-1].get_ydata()) == [9, 9]
    assert ax.get_ylim()[1] > 9
    assert legend(figure)[-1] == "breaking strength"
    assert ax.get_title() == "rope: at most 3 kN, at 2.5 m"


def test_a_strength_far_above_the_tensions_is_told_in_the_title(tmp_path):
    saved = np.array([[[1e3, 2e3], [3e3, 1e3]]])
    figure = figures_of(lines(tmp_path / "a.h5", {"rope": saved}, strength=[9.1e3]))[
        "tension_range"
    ]
    (ax,) = figure.axes
    assert len(ax.lines) == 3
    assert ax.get_ylim()[1] < 4
    assert "breaking strength" not in legend(figure)
    title = ax.get_title().replace("\n", " ")
    assert title == "rope: at most 3 kN, at 2.5 m; breaking strength 9.1 kN"


@pytest.mark.parametrize(("strength", "count"), [([2e3, 2e3], 3), ([2e3, 4e3], 2)])
def test_of_several_runs_a_strength_that_all_have(tmp_path, strength, count):
    saved = np.array([[[1e3], [2e3]], [[5e3], [1e3]]])
    path = lines(tmp_path / "a.h5", {"rope": saved}, status=(1, 1), strength=strength)
    (ax,) = figures_of(path)["tension_range"].axes
    assert len(ax.lines) == count


def test_lines_that_part_have_figures_of_their_own(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), break_times=(5e-3,), segments=6)
    assert "tension_range" not in figures_of(path)
