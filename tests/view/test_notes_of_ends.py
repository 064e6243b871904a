"""What pictures say of runs that went wrong, and of those that are not computed yet."""

import h5py
import numpy as np
import pytest

from lumpedcable.results import open_result
from lumpedcable.results.schema import SCHEMA_VERSION
from lumpedcable.view.groups import ends_note, groups
from lumpedcable.view.maps import map_figures
from lumpedcable.view.measures import bars_figure
from lumpedcable.view.rest import rest_figure

CODES = {"ok": 0, "line_reversed": 4, "interrupted": 6, "still_moving": 9}
WRONG = "1 of 9 runs went wrong"
COUNTS = f"{WRONG}; what they came to before counts."
# those of one map: two swept numbers of three values each
MIXED = ["ok"] * 3 + ["still_moving"] * 2 + ["line_reversed"] + ["interrupted"] * 3


def made(path, ends):
    """A file of nine runs over two swept numbers that ended so, each with a measure and a shape."""
    runs = len(ends)
    length, mass = np.divmod(np.arange(runs), 3)
    with h5py.File(path, "w") as file:
        file.attrs.update(complete=True, schema_version=SCHEMA_VERSION)
        file["run"], file["time"] = np.arange(runs), np.array([0.0])
        file["status"] = np.array([CODES[end] for end in ends])
        file["status"].attrs.update(flag_meanings=" ".join(CODES), flag_values=list(CODES.values()))
        for name, values in (("lines.a.length", length), ("lines.a.mass", mass)):
            short = name.split(".")[-1]
            file[short] = 1.0 + values
            file[short].attrs.update(key=name, units="m", long_name=short)
        file["summary/gap"] = np.arange(runs) + 1.0
        file["summary/gap"].attrs.update(units="m", long_name="gap", extreme="largest")
    return path


def foot(figure):
    """What stands below a figure."""
    texts = [legend.get_title().get_text() for legend in figure.legends]
    return " ".join(" ".join([*texts, *(text.get_text() for text in figure.texts)]).split())


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        (["ok"] * 9, ""),
        (["still_moving"] * 9, ""),
        (["line_reversed"] + ["ok"] * 8, COUNTS),
        (["interrupted"] + ["ok"] * 8, "1 of 9 runs is not computed yet."),
        (MIXED, f"{COUNTS} 3 of 9 runs are not computed yet."),
        (["ok"], ""),
        (["line_reversed"], ""),
    ],
)
def test_runs_count_as_wrong_that_are_and_those_to_come_apart(tmp_path, ends, said):
    with open_result(made(tmp_path / "r.h5", ends)) as result:
        every = range(result.runs)
        assert ends_note(result, every, "what they came to before counts") == said


def test_maps_and_bars_say_so(tmp_path):
    with open_result(made(tmp_path / "r.h5", MIXED)) as result:
        (_, draw), *_ = map_figures(result)
        for figure in (draw(), bars_figure(result, "gap")):
            assert f"{COUNTS} 3 of 9 runs are not computed yet." in foot(figure)


def test_pictures_of_scenes_at_rest_say_so(tmp_path):
    # of an unfinished study
    path = made(tmp_path / "r.h5", MIXED)
    with h5py.File(path, "r+") as file:
        for name in ("sag", "length", "start_tension", "end_tension", "horizontal_tension"):
            file[f"rest/a/{name}"] = np.ones(9)
        place = np.zeros((9, 1, 2, 3))
        place[..., 1, 0] = 1.0
        file["lines/a/position"] = place
    with open_result(path) as result:
        first = groups(result)[0]
        figure = rest_figure(result, "a", first)
    assert len(first.every) == 3
    assert "1 of 3 runs is not computed yet." in foot(figure)
    assert "went wrong" not in foot(figure)
