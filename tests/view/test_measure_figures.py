"""Bars and curves of the numbers that a scene asks for, from a file made by hand."""

from itertools import pairwise

import h5py
import numpy as np
import pytest

from lumpedcable.results import open_result
from lumpedcable.results.schema import SCHEMA_VERSION
from lumpedcable.view import figures_of, plot_result

HEIGHTS = (4.0, 2.5, 3.5)
NAMES = ("calm", r"$50 or $60 \bad{", "in between")


@pytest.fixture
def file(tmp_path):
    """Three named runs of one measure: a parabola over time down to its least height."""
    time = np.linspace(0.0, 10.0, 21)
    with h5py.File(tmp_path / "heights.h5", "w") as made:
        made.attrs.update(complete=True, schema_version=SCHEMA_VERSION)
        made.attrs["title"] = "Heights"
        made["run"], made["time"] = np.arange(3), time
        made["status"] = np.zeros(3, int)
        made["status"].attrs.update(flag_meanings="ok", flag_values=[0])
        made["case"] = np.array(NAMES, object)
        table = np.array(HEIGHTS)[:, None] + 0.1 * (time - 5.0) ** 2
        made["measures/h_d"], made["summary/h_d"] = table, table.min(axis=1)
        made["energy/kinetic"] = np.zeros((3, 21))
        for path, words in (("measures/h_d", "height"), ("summary/h_d", "least height")):
            made[path].attrs.update(units="m", long_name=words, limit=3.0)
    return tmp_path / "heights.h5"


def test_bars_are_the_numbers_of_the_runs(file):
    figure = figures_of(file)["bars_h_d"]
    (ax,) = figure.axes
    assert [bar.get_height() for bar in ax.patches] == pytest.approx(HEIGHTS)
    assert [label.get_text() for label in ax.get_xticklabels()] == list(NAMES)
    (limit,) = ax.lines
    assert list(limit.get_ydata()) == [3.0, 3.0]
    low, high = ax.get_ylim()
    assert low <= 0.0 < 4.0 < high
    assert ax.get_xlim() == (-0.5, len(HEIGHTS) - 0.5)
    assert "least height (m)" in ax.get_ylabel()
    figure.canvas.draw()  # the dollars of a name open no formula, at an axis neither


def test_long_names_stand_beside_their_bars(file, tmp_path):
    words = ["supply heave amplitude 170 mm", "receiver heave amplitude 220 mm", "roll 0.368 deg"]
    names = [", ".join([f"case {k}", *words, *words]) for k in range(3)]
    with h5py.File(file, "r+") as made:
        made["case"][:] = np.array(names, object)
    figure = figures_of(file)["bars_h_d"]
    (ax,) = figure.axes
    assert [bar.get_width() for bar in ax.patches] == pytest.approx(HEIGHTS)
    assert [t.get_text().replace("\n", " ") for t in ax.get_yticklabels()] == names
    assert ax.get_ylim() == (len(HEIGHTS) - 0.5, -0.5)
    (limit,) = ax.lines
    assert list(limit.get_xdata()) == [3.0, 3.0]
    # all text lies within the figure, and none on another
    figure.savefig(tmp_path / "bars.png")
    boxes = [label.get_window_extent() for label in ax.get_yticklabels()]
    assert min(box.x0 for box in boxes) >= 0.0
    assert all(a.y0 >= b.y1 for a, b in pairwise(boxes))
    assert ax.get_window_extent().width > 2.0 * figure.dpi


def test_curves_are_called_by_the_names_of_cases(file, tmp_path):
    figure = figures_of(file)["measure_h_d"]
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert texts == [*NAMES, "limit"]
    with open_result(file) as result:
        assert result.cases == list(NAMES)
    made = {path.name for path in plot_result(file, tmp_path / "out")}
    assert {"bars_h_d.png", "measure_h_d.png"} <= made


def test_a_limit_far_off_is_told_in_a_unit_that_suits_both(file):
    with h5py.File(file, "r+") as made:
        for path in ("measures/h_d", "summary/h_d"):
            made[path][...] = 100.0 * made[path][...]
            made[path].attrs.update(units="N", long_name="tension", limit=2e6)
    figures = figures_of(file)
    for name in ("measure_h_d", "bars_h_d"):
        (ax,) = figures[name].axes
        assert ax.get_ylabel() == "tension (kN)"
        assert ax.get_ylim()[1] > 2000.0
