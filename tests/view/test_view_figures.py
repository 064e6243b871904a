"""What the figures show: curves against closed forms, labels, nothing cut off or overlapping."""

import itertools
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.text import Text
from synthetic_result import LENGTH, MASS, PRETENSIONS, SPEED, TIMES, snapback, wave

from lumpedcable.results import Coordinate, ResultWriter, Variable, open_result
from lumpedcable.results.sound import SoundFile
from lumpedcable.view import style
from lumpedcable.view.energy import energy_figure
from lumpedcable.view.general import end_tension_figure, shape_figure
from lumpedcable.view.groups import Group, groups
from lumpedcable.view.recoil import (
    end_speed_figure,
    tension_figure,
    velocity_figure,
    xt_figure,
)
from lumpedcable.view.sampling import RecoilingEnd

RECOIL = (tension_figure, velocity_figure, end_speed_figure, xt_figure)
EVERY_10_MS = TIMES[::10]


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    path = snapback(
        tmp_path_factory.mktemp("view") / "sweep.h5", segments=30, failed=(3,), padded=4
    )
    with open_result(path) as result:
        yield result


def drawn(make, result, *arguments):
    with style.styled():
        figure = make(result, *arguments)
        figure.draw_without_rendering()
    return figure


def panels(figure):
    """The axes that hold curves, without colour bars."""
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


@pytest.mark.parametrize("place", [0, 1])
def test_tension_curves_are_those_of_the_closed_form_every_10_ms(sweep, place):
    group = groups(sweep)[place]
    figure = drawn(tension_figure, sweep, RecoilingEnd(sweep, "rope.end"), group)
    break_time = (5e-3, 50e-3)[place]
    middle = (np.arange(30) + 0.5) * LENGTH / 30
    for ax, run in zip(panels(figure), group.runs, strict=True):
        (curves,) = [c for c in ax.collections if isinstance(c, LineCollection)]
        pretension = PRETENSIONS[run // 2]
        expected, _ = wave(middle, EVERY_10_MS, pretension, break_time)
        kept = 10 if run == 3 else 21  # of the failed run, the times before it failed
        found = np.array(curves.get_segments())
        assert found.shape == (kept, 30, 2)
        np.testing.assert_allclose(found[:, :, 0], np.tile(middle, (kept, 1)))
        np.testing.assert_allclose(found[:, :, 1], expected[:kept] / 1e3, atol=pretension * 1e-9)
        np.testing.assert_allclose(curves.get_array(), EVERY_10_MS[:kept] * 1e3)
    left, right, lower = panels(figure)[:3]
    assert (left.get_ylabel(), right.get_ylabel()) == ("tension (kN)", "")
    assert (left.get_xlabel(), lower.get_xlabel()) == ("", "unstretched position (m)")


def test_velocity_is_positive_away_from_the_break(sweep):
    group = groups(sweep)[0]
    figure = drawn(velocity_figure, sweep, RecoilingEnd(sweep, "rope.end"), group)
    node = np.linspace(0, LENGTH, 31)
    _, expected = wave(node, EVERY_10_MS, PRETENSIONS[3], 5e-3)
    found = np.array(panels(figure)[3].collections[0].get_segments())
    assert found[..., 1].max() > 200
    np.testing.assert_allclose(found[..., 1], -expected, atol=1e-4)
    assert panels(figure)[0].get_ylabel() == "recoil velocity (m/s)"


def test_velocity_follows_a_line_that_does_not_lie_along_x(tmp_path):
    """A line broken at its start, hanging down and then level; recoil is towards its end."""
    at = np.array([[0.0, 0, 0], [0, 0, -1], [0, 0, -2], [0, 1, -2], [0, 2, -2]])
    speed = np.zeros((1, 2, 5, 3))
    speed[0, 1, 0] = [3.0, 0.0, -5.0]  # 5 down along the line, 3 across it
    speed[0, 1, 4] = [0.0, 7.0, 0.0]
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 1, "time": 2, "xyz": 3, "lines/rope/node": 5},
        variables=[
            Variable("lines/rope/position", ("run", "time", "node", "xyz")),
            Variable("lines/rope/velocity", ("run", "time", "node", "xyz")),
            Variable("summary/rope.start/peak_end_speed", ("run",)),
        ],
        coordinates={
            "time": Coordinate([0.0, 1.0], "s"),
            "lines/rope/unstretched_position": Coordinate(np.arange(5.0), "m", dims=("node",)),
        },
    ) as writer:
        writer.write("lines/rope/position", np.broadcast_to(at, (1, 2, 5, 3)))
        writer.write("lines/rope/velocity", speed)
    with open_result(tmp_path / "a.h5") as result:
        end = RecoilingEnd(result, "rope.start")
        _, recoil = end.recoil(0)
        np.testing.assert_allclose(recoil[1], [5, 0, 0, 0, 7])
        np.testing.assert_allclose(end.speed(0), [0, np.hypot(3, 5)])
        assert end.places(0) == (0.0, 4.0)
        assert end.start(0) == 0.0
        assert end.exact_speed(0) is None
        assert end.arrivals(0) == []


def test_end_speeds_with_their_exact_values(sweep):
    group = groups(sweep)[1]
    figure = drawn(end_speed_figure, sweep, RecoilingEnd(sweep, "rope.end"), group)
    (ax,) = panels(figure)
    curves = [line for line in ax.lines if len(line.get_xdata()) == 201]
    exact = [line for line in ax.lines if len(line.get_xdata()) == 2]
    assert len(curves) == len(exact) == 4
    for curve, level, pretension in zip(curves, exact, PRETENSIONS, strict=True):
        _, expected = wave([LENGTH], TIMES, pretension, 50e-3)
        kept = np.isfinite(curve.get_ydata())
        np.testing.assert_allclose(
            curve.get_ydata()[kept], np.abs(expected[kept, 0]), atol=pretension * 1e-9
        )
        assert level.get_ydata()[0] == pytest.approx(pretension / (MASS * SPEED))
        assert level.get_color() == curve.get_color()
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [
        "pretension 45 kN",
        "pretension 180 kN: diverged at 100 ms",
        "pretension 315 kN",
        "pretension 450 kN",
        "exact: instantaneous break, no drag",
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (ms)", "speed of the broken end (m/s)")


def test_the_front_runs_from_the_broken_end_to_the_other(sweep):
    group = groups(sweep)[0]
    figure = drawn(xt_figure, sweep, RecoilingEnd(sweep, "rope.end"), group)
    for ax, run in zip(panels(figure), group.runs, strict=True):
        front, mark = ax.lines
        np.testing.assert_allclose(front.get_xdata(), [LENGTH, 0])
        np.testing.assert_allclose(front.get_ydata(), [0, LENGTH / SPEED * 1e3])
        np.testing.assert_allclose([*mark.get_xdata(), *mark.get_ydata()], [0, 73.3])
        (mesh,) = [c for c in ax.collections if isinstance(c, QuadMesh)]
        middle = (np.arange(30) + 0.5) * LENGTH / 30
        expected, _ = wave(middle, TIMES, PRETENSIONS[run // 2], 5e-3)
        np.testing.assert_allclose(mesh.get_array(), expected / 1e3, atol=1e-3)
        corners = mesh.get_coordinates()
        np.testing.assert_allclose(corners[0, :, 0], np.linspace(0, LENGTH, 31), atol=1e-12)
        np.testing.assert_allclose(corners[[0, 1, -1], 0, 1], [0, 0.5, 200])
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [
        "exact front (instantaneous break, no drag)",
        "front arrival in A book for the scene without --set",  # which the file tells was given
    ]


def test_a_later_break_moves_the_front(tmp_path):
    path = snapback(
        tmp_path / "a.h5", pretensions=(45e3,), break_times=(5e-3,), segments=5, break_start=0.02
    )
    with open_result(path) as result:
        figure = drawn(xt_figure, result, RecoilingEnd(result, "rope.end"), groups(result)[0])
        front = panels(figure)[0].lines[0]
        np.testing.assert_allclose(front.get_ydata(), [20, 20 + LENGTH / SPEED * 1e3])


@pytest.mark.slow
def test_lines_pushed_hard_get_two_hues_and_others_one(tmp_path, sweep):
    end = RecoilingEnd(sweep, "rope.end")
    for group in groups(sweep):
        for ax in panels(drawn(xt_figure, sweep, end, group)):
            low, high = ax.collections[0].get_clim()
            assert low == -high < 0
    # before the front is back from the wall nothing is pushed
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), times=TIMES[:70], segments=5)
    with open_result(path) as result:
        figure = drawn(xt_figure, result, RecoilingEnd(result, "rope.end"), groups(result)[0])
        assert panels(figure)[0].collections[0].get_clim() == (0, pytest.approx(45))


def test_energies_and_residual_have_scales_of_their_own(sweep):
    group = groups(sweep)[0]
    figure = drawn(energy_figure, sweep, group)
    upper, lower = panels(figure)[::2], panels(figure)[1::2]
    for ax, below, run in zip(upper, lower, group.runs, strict=True):
        assert len(ax.lines) == 2
        np.testing.assert_allclose(ax.lines[0].get_ydata(), sweep.energy("kinetic", run) / 1e3)
        np.testing.assert_allclose(below.lines[0].get_ydata(), sweep.energy("residual", run) * 1e3)
    assert upper[0].get_ylabel() == "energy (kJ)"
    assert lower[0].get_ylabel() == "residual\n(mJ)"
    assert lower[2].get_xlabel() == "time (ms)"
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["kinetic", "strain"]


def test_terms_that_are_zero_throughout_are_left_out(tmp_path):
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 1, "time": 3},
        variables=[
            Variable("energy/kinetic", ("run", "time"), "f8", "J", "kinetic energy"),
            Variable("energy/gravitational", ("run", "time"), "f8", "J"),
        ],
        coordinates={"time": Coordinate([0.0, 1.0, 2.0], "s")},
    ) as writer:
        writer.write("energy/kinetic", [[0.0, 1.0, 2.0]])
        writer.write("energy/gravitational", np.zeros((1, 3)))
    with open_result(tmp_path / "a.h5") as result:
        figure = drawn(energy_figure, result, groups(result)[0])
        (ax,) = panels(figure)
        assert len(ax.lines) == 1
        assert [t.get_text() for t in figure.legends[0].get_texts()] == ["kinetic energy"]


def test_a_term_looks_the_same_in_all_figures_of_a_file(tmp_path):
    # the one in between is too small to be seen in the first run alone
    sizes = {"drag": [5.0, 5.0], "lost": [1e-3, 1.0], "strain": [4.0, 4.0]}
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 2, "time": 2},
        variables=[Variable(f"energy/{n}", ("run", "time"), "f8", "J") for n in sizes],
        coordinates={"time": Coordinate([0.0, 1.0], "s")},
    ) as writer:
        for name, values in sizes.items():
            writer.write(f"energy/{name}", np.array(values)[:, None] * [0.0, 1.0])
    with open_result(tmp_path / "a.h5") as result:
        both = [
            {
                line.get_label(): (line.get_color(), line.get_linestyle())
                for line in drawn(energy_figure, result, group).legends[0].get_lines()
            }
            for group in (Group("", "", (run,), ("",), "", (run,)) for run in (0, 1))
        ]
    assert list(both[0]) == ["drag", "strain"]
    assert list(both[1]) == ["drag", "lost", "strain"]
    assert len(set(both[1].values())) == 3
    assert all(both[1][name] == look for name, look in both[0].items())


def test_tension_at_the_ends_of_a_line_that_holds(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), broken=False, padded=3, segments=20)
    with open_result(path) as result:
        figure = drawn(end_tension_figure, result, groups(result)[1])
        (ax,) = panels(figure)
        expected, _ = wave([1.5, 58.5], TIMES, 45e3, 50e-3)  # middles of the end segments
        for line, values in zip(ax.lines, expected.T, strict=True):
            np.testing.assert_allclose(line.get_ydata(), values / 1e3, atol=1e-4)
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        assert texts == ["rope.start", "rope.end"]


@pytest.mark.parametrize(("sag", "true"), [(15.0, True), (2.0, False), (1.5e-13, True)])
def test_shapes_are_true_to_scale_unless_too_flat(tmp_path, sag, true):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), broken=False, sag=sag, segments=20)
    with SoundFile.open(path) as result:
        figure = drawn(shape_figure, result, groups(result)[0])
        (ax,) = panels(figure)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (m)", "z (m)")
        assert len(ax.lines) == 5  # times
        first = result.line("rope").position(0, 0)
        np.testing.assert_array_equal(ax.lines[0].get_ydata(), first[:, 2])
        assert (ax.get_aspect() == 1.0) is true
        assert (figure.get_supxlabel() == "Vertical scale stretched.") is not true
        if true:  # the sag is no larger than it is, also where it is rounding
            assert np.ptp(ax.get_ylim()) > 1.0


def test_a_panel_without_data_says_so(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=PRETENSIONS[:2], segments=5, lost=(2,))
    with open_result(path) as result:
        end, group = RecoilingEnd(result, "rope.end"), groups(result)[0]
        for make in (tension_figure, velocity_figure, xt_figure):
            ax = panels(drawn(make, result, end, group))
            said = [[text.get_text() for text in panel.texts] for panel in ax]
            assert said == [[], ["no data"]]
        said = [
            [t.get_text() for t in p.texts] for p in panels(drawn(energy_figure, result, group))
        ]
        assert said == [[], [], ["no data"], []]


def shown_texts(figure):
    """All texts that are drawn, with the boxes they fill."""
    found = []
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text().strip():
            found.append(text)
    hidden = set()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            room = 1e-9 * (high - low)
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not low - room <= tick.get_loc() <= high + room:
                    hidden |= {tick.label1, tick.label2}
    return [(t.get_text(), t.get_window_extent()) for t in found if t not in hidden]


def faults(figure):
    """Texts that are cut off by the figure's edge or overlap another text."""
    found = []
    texts, edge = shown_texts(figure), figure.bbox
    for text, box in texts:
        if not (
            edge.x0 <= box.x0 and box.x1 <= edge.x1 and edge.y0 <= box.y0 and box.y1 <= edge.y1
        ):
            found.append(f"{text!r} is cut off")
    for (one, a), (other, b) in itertools.combinations(texts, 2):
        if not (a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0):
            found.append(f"{one!r} overlaps {other!r}")
    return found


SCENES = {
    "sweep": {"segments": 12},
    "one": {"segments": 12, "pretensions": (45e3,), "break_times": (5e-3,), "swept": False},
    "many": {
        "segments": 12,
        "pretensions": tuple(np.linspace(1e4, 5e5, 30)),
        "break_times": (5e-3,),
        "failed": range(10, 20),
    },
    "holding": {"segments": 12, "broken": False, "sag": 15.0, "failed": (1,)},
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(k, marks=pytest.mark.slow) if k in ("many", "sweep") else k for k in SCENES],
)
def test_no_text_is_cut_off_or_overlaps_another(tmp_path, name):
    path = snapback(tmp_path / "a.h5", **SCENES[name])
    with SoundFile.open(path) as result:
        group = groups(result)[-1]
        ends = [RecoilingEnd(result, end) for end in result.ends]
        figures = [drawn(make, result, end, group) for end in ends for make in RECOIL]
        if not ends:
            figures += [drawn(make, result, group) for make in (end_tension_figure, shape_figure)]
        figures.append(drawn(energy_figure, result, group))
    for figure in figures:
        assert len(shown_texts(figure)) > 10
        assert faults(figure) == []


def test_the_check_of_texts_finds_faults():
    with style.styled():
        figure = style.new_figure(2.0, "")
        figure.text(0.5, 0.5, "one")
        figure.text(0.51, 0.5, "other")
        figure.text(0.98, 0.9, "too far right")
        figure.draw_without_rendering()
    assert faults(figure) == ["'too far right' is cut off", "'one' overlaps 'other'"]


def test_many_curves_all_look_different():
    looks = [(look["color"], str(look["linestyle"])) for look in map(style.curve, range(28))]
    assert len(set(looks)) == 28


def test_drawing_leaves_the_global_state_alone(sweep):
    before = dict(matplotlib.rcParams)
    drawn(energy_figure, sweep, groups(sweep)[0])
    assert dict(matplotlib.rcParams) == before


def test_the_view_loads_neither_pyplot_nor_the_engine():
    code = (
        "import sys, lumpedcable.view;"
        "print([m for m in ('matplotlib.pyplot', 'jax', 'lumpedcable.model') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"
