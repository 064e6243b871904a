"""Which figures are made, what they are called, what is refused, and how runs are picked."""

import struct

import numpy as np
import pytest
from synthetic_result import snapback

from lumpedcable.results import (
    Coordinate,
    OutputError,
    ResultError,
    ResultWriter,
    Variable,
    open_result,
    sweep_coordinates,
)
from lumpedcable.view import figures_of, plot_result, style
from lumpedcable.view.groups import alone, file_tag, groups
from lumpedcable.view.sampling import RecoilingEnd, curve_times

FIGURES = ("tension", "velocity", "end_speed", "xt", "energy")
ONE = {"pretensions": (45e3,), "break_times": (5e-3,)}
TWO = {"pretensions": (45e3, 180e3), "break_times": (5e-3,)}


def test_a_sweep_gives_a_set_of_figures_for_each_break_time(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), segments=6)
    made = plot_result(path, tmp_path / "new" / "figures")
    assert [file.name for file in made] == [
        f"{name}_break_time_{value}.png" for value in ("5ms", "50ms") for name in FIGURES
    ]
    for file in made:
        head = file.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", head[16:])
        assert width == style.WIDTH * 200  # pixels: the printed width at 200 to the inch
        assert 500 < height < 2000


@pytest.mark.slow
def test_a_single_run_in_other_formats(tmp_path):
    path = snapback(tmp_path / "a.h5", **ONE, segments=6, swept=False)
    made = plot_result(path, tmp_path, ("pdf", "svg"))
    assert [f.name for f in made] == [f"{n}.{kind}" for n in FIGURES for kind in ("pdf", "svg")]
    assert made[0].read_bytes().startswith(b"%PDF")
    assert "<svg" in made[1].read_text()


def test_a_line_that_holds(tmp_path):
    path = snapback(tmp_path / "a.h5", **ONE, segments=6, broken=False)
    made = plot_result(path, tmp_path)
    assert [file.name for file in made] == [
        "end_tension.png",
        "tension_range.png",
        "shape.png",
        "energy.png",
    ]


@pytest.mark.parametrize("end", [None, "rope.end"])
def test_tension_at_the_ends_is_that_which_is_kept_of_them(tmp_path, end):
    # a chain that hangs: 100 kN at the top and nothing at its free end, whatever its segments have
    along = ("run", "time")
    variables = [
        Variable("lines/rope/start_tension", along, "f8", "N"),
        Variable("lines/rope/end_tension", along, "f8", "N"),
    ]
    if end is None:
        variables.append(Variable("lines/rope/tension", (*along, "segment"), "f8", "N"))
    else:
        variables.append(Variable(f"summary/{end}/peak_end_speed", ("run",), "f8", "m/s"))
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 1, "time": 2, "lines/rope/segment": 4},
        variables=variables,
        coordinates={"time": Coordinate([0.0, 1.0], "s")},
    ) as writer:
        writer.write("lines/rope/start_tension", np.full((1, 2), 100e3))
        writer.write("lines/rope/end_tension", np.zeros((1, 2)))
        if end is None:
            writer.write("lines/rope/tension", np.tile([87.5e3, 62.5e3, 37.5e3, 12.5e3], (1, 2, 1)))
    figure = figures_of(tmp_path / "a.h5")["end_tension"]
    (ax,) = figure.axes
    assert ax.get_ylabel() == "tension (kN)"
    assert [set(line.get_ydata()) for line in ax.lines] == [{100.0}, {0.0}]


def test_fields_that_were_not_stored_cost_only_their_figures(tmp_path):
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 1, "time": 1, "xyz": 3, "lines/rope/node": 3},
        variables=[
            Variable("lines/rope/velocity", ("run", "time", "node", "xyz"), "f8", "m/s"),
            Variable("summary/rope.end/peak_end_speed", ("run",), "f8", "m/s"),
            Variable("summary/rope.start/peak_end_speed", ("run",), "f8", "m/s"),
        ],
        coordinates={
            "time": Coordinate([0.0], "s"),
            "lines/rope/unstretched_position": Coordinate([0.0, 1, 2], "m", dims=("node",)),
        },
    ) as writer:
        writer.write("lines/rope/velocity", np.ones((1, 1, 3, 3)))
    made = plot_result(tmp_path / "a.h5", tmp_path)  # two recoiling ends, one saved time
    assert [f.name for f in made] == ["end_speed_rope.end.png", "end_speed_rope.start.png"]


def test_a_single_saved_time(tmp_path):
    path = snapback(tmp_path / "a.h5", times=np.zeros(1), segments=4, **ONE)
    assert len(plot_result(path, tmp_path)) == 5


def test_an_unfinished_study_is_drawn_as_far_as_it_came(tmp_path):
    path = snapback(tmp_path / "a.h5", **TWO, segments=6, failed=(0,), lost=(1,), finish=False)
    assert path.name == "a.h5.partial"
    assert len(plot_result(path, tmp_path)) == 5
    with open_result(path) as result:
        (group,) = groups(result)
        assert group.note == "The study is incomplete."
        assert group.titles[0] == "pretension 45 kN\ndiverged at 100 ms"


def test_a_run_alone(tmp_path):
    path = snapback(tmp_path / "a.h5", pretensions=(45e3,), segments=6)
    made = plot_result(path, tmp_path, run=1)
    assert [file.name for file in made] == [f"{name}_run_1.png" for name in FIGURES]
    with open_result(path) as result:
        group = alone(result, 1)
    assert (group.runs, group.titles) == ((1,), ("run 1",))
    assert group.label == "pretension 45 kN, break time 50 ms"
    single = snapback(tmp_path / "b.h5", **ONE, segments=6, swept=False)
    assert [f.name for f in plot_result(single, tmp_path, run=0)] == [f"{n}.png" for n in FIGURES]


def test_what_is_refused(tmp_path):
    path = snapback(tmp_path / "a.h5", **ONE, segments=4)
    with pytest.raises(OutputError, match=r"format 'jpg', expected one of pdf, png, svg"):
        plot_result(path, tmp_path, ("jpg",))
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="expected a folder for the pictures, found"):
        plot_result(path, tmp_path / "file")
    (tmp_path / "figures" / "tension.png").mkdir(parents=True)
    with pytest.raises(OutputError, match=r"cannot write .*tension\.png: Is a directory"):
        plot_result(path, tmp_path / "figures")
    with pytest.raises(ResultError, match="no such file"):
        plot_result(tmp_path / "absent.h5", tmp_path)
    with ResultWriter(tmp_path / "empty.h5", dims={"run": 1, "time": 1}, variables=[]):
        pass
    with pytest.raises(ResultError, match="neither histories nor a sweep"):
        plot_result(tmp_path / "empty.h5", tmp_path)
    with open_result(path) as result, pytest.raises(ResultError, match=r"expected LINE\.start or"):
        RecoilingEnd(result, "chain.end")


def swept(path, *axes):
    """A results file of nothing but swept numbers."""
    count = len(axes[0][2])
    ResultWriter(
        path,
        dims={"run": count, "time": 1},
        variables=[],
        coordinates=sweep_coordinates(axes),
    ).finish()
    return open_result(path)


def test_groups_follow_the_last_swept_number(tmp_path):
    with swept(
        tmp_path / "a.h5",
        ("gravity", "m/s2", [9.8] * 6),
        ("lines.rope.end.held.pretension", "N", [1e3, 1e3, 1e3, 2e3, 2e3, 2e3]),
        ("events.break.time", "s", [0.0, 0.005, 0.00500000001] * 2),
    ) as result:
        made = groups(result)
    assert [group.runs for group in made] == [(0, 3), (1, 4), (2, 5)]
    assert [group.tag for group in made] == [
        "break_time_0s",
        "break_time_5ms",
        "break_time_5ms_2",  # another value, though it reads the same
    ]
    assert made[1].label == "gravity 9.8 m/s2, break time 5 ms"
    assert made[1].titles == ("pretension 1 kN", "pretension 2 kN")
    assert [group.note for group in made] == [""] * 3


def test_one_swept_number_makes_one_group(tmp_path):
    with swept(tmp_path / "a.h5", ("events.break.time", "s", [0.005, 0.05])) as result:
        (group,) = groups(result)
    assert (group.tag, group.label) == ("", "")
    assert group.titles == ("break time 5 ms", "break time 50 ms")


def test_too_many_runs_are_thinned_evenly_and_said_so(tmp_path):
    values = np.arange(23.0)
    with swept(
        tmp_path / "a.h5", ("gravity", "m/s2", values), ("water.density", "kg/m3", values)
    ) as result:
        (group,) = groups(result)
    assert group.runs == tuple(range(0, 23, 2))
    assert group.note == "12 of 23 runs shown: numbers 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22."
    assert group.titles[1] == "gravity 2 m/s2, water density 2 kg/m3"


@pytest.mark.parametrize(
    ("label", "tag"),
    [
        ("break time 5 ms", "break_time_5ms"),
        ("break time 2.5 µs", "break_time_2.5us"),
        ("water density 1025 kg/m3", "water_density_1025kg_per_m3"),
        ("damping 2 kN s", "damping_2kN_s"),
        ("place -3 m", "place_-3m"),
    ],
)
def test_labels_as_file_names(label, tag):
    assert file_tag(label) == tag


@pytest.mark.parametrize(
    ("last", "every", "spacing", "curves"),
    [
        (0.2, 1e-3, 0.010, 21),  # as in the published figures
        (0.25, 1e-3, 0.010, 26),
        (0.2, 20e-3, 0.020, 11),  # saved more coarsely than that: all there is
        (0.02, 1e-4, 0.001, 21),
        (60.0, 0.1, 2.0, 31),
        (0.201, 3e-3, 0.009, 23),  # 10 ms are no multiple of them: every third
        (0.196, 7e-3, 0.007, 29),
    ],
)
def test_curves_come_at_round_times(last, every, spacing, curves):
    time = np.arange(0, last + every / 2, every)
    picked, found = curve_times(time)
    assert found == pytest.approx(spacing)
    assert len(picked) == curves
    off = time[picked] - np.arange(curves) * spacing
    assert np.abs(off).max() <= every / 2 + 1e-12
