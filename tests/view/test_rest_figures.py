"""Pictures and tables of scenes at rest: each of its own runs, told apart, with their own numbers."""

import numpy as np
import pytest
from command_line import say
from engine_runs import run_text

from lumpedcable.results import open_result
from lumpedcable.view.plot import figures_of

SCENE = """
gravity = 9.81

[materials.wire]
law = "linear"
EA = "20 MN"

[lines.a]
material = "wire"
length = "61 m"
segments = 6
mass = "3 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = [60, 0, 0] }

[output]
"""
GRID = '[sweep]\n"lines.a.mass" = [3, 6]\n"lines.a.length" = [61, 62, 65]\n'
ZIP = '[[sweep.zip]]\n"lines.a.mass" = [3, 4, 6]\n"lines.a.length" = [61, 62, 65]\n'
CASES = "".join(
    f'[[sweep.cases]]\nname = "{name}"\n"lines.a.length" = {length}\n'
    for name, length in (("taut", 61), ("slack", 65))
)


@pytest.mark.slow
def test_panels_of_a_group_hold_its_runs_alone(tmp_path):
    run_text(tmp_path, SCENE + GRID)
    figures = figures_of(tmp_path / "result.h5")
    with open_result(tmp_path / "result.h5") as result:
        numbers = result.rest("a")
        (mass, length) = (axis.values for axis in result.axes)
    for value in (61.0, 62.0, 65.0):
        own = np.flatnonzero(length == value)
        _, _, sag, tension = figures[f"rest_a_length_{value:.0f}m"].axes[:4]
        for panel, key, factor in ((sag, "sag", 1.0), (tension, "start_tension", 1e-3)):
            drawn = next(line for line in panel.lines if line.get_linestyle() == "None")
            assert drawn.get_xdata().tolist() == mass[own].tolist()
            np.testing.assert_allclose(drawn.get_ydata(), numbers[key][own] * factor)


@pytest.mark.slow
def test_runs_that_no_one_number_tells_apart_have_a_legend_and_no_numbers_of_one(tmp_path):
    run_text(tmp_path, SCENE + ZIP)
    figure = figures_of(tmp_path / "result.h5")["rest"]
    (ax,) = figure.axes
    assert ax.get_title() == ""
    assert len({line.get_color() for line in ax.lines}) == 3
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert [("61" in text, "62" in text, "65" in text) for text in texts[:3]] == [
        (True, False, False), (False, True, False), (False, False, True)
    ]  # fmt: skip


@pytest.mark.slow
def test_the_table_names_cases(tmp_path):
    (tmp_path / "s.toml").write_text(SCENE + CASES)
    told = say(tmp_path, "run", "s.toml").out
    assert "case" in told
    rows = [line.split() for line in told.splitlines() if "taut" in line or "slack" in line]
    assert [row[1] for row in rows] == ["taut", "slack"]


@pytest.mark.parametrize("names", [True, False])
@pytest.mark.slow
def test_one_number_of_cases_is_drawn_along_it(tmp_path, names):
    cases = CASES if names else CASES.replace('name = "taut"\n', "").replace('name = "slack"\n', "")
    run_text(tmp_path, SCENE + cases)
    figure = figures_of(tmp_path / "result.h5")["rest"]
    drawn = figure.axes[2].lines[-1]
    assert drawn.get_xdata().tolist() == [61.0, 65.0]


@pytest.mark.slow
def test_runs_that_went_wrong_are_counted(tmp_path):
    # of 61 m and more a thousandth of stretch is enough, of 58 m it is not
    text = SCENE.replace('law = "linear"', 'law = "linear"\nmax_strain = 1e-3')
    ran = run_text(tmp_path, text + '[sweep]\n"lines.a.length" = [58, 61, 62]\n')
    assert ran.statuses == ["STRAIN_EXCEEDED", "OK", "OK"]
    figure = figures_of(tmp_path / "result.h5")["rest"]
    assert figure.legends[0].get_title().get_text() == "1 of 3 runs went wrong."
