"""Place and velocity of broken ends over time, which need no fields: against the exact wave."""

import csv

import numpy as np
import pytest
from engine_runs import HOOKE, ROPE, run_text

import lumpedcable
from lumpedcable.export import export_result
from lumpedcable.page.recorded import recorded
from lumpedcable.results import describe, open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study
from lumpedcable.study.shards import Share, open_study, run_here
from lumpedcable.view.plot import figures_of

# 50 kN let go over 40 ms, twenty segments of 2 m at 1000 m/s: a smooth front
BREAKS, SPEED, OVER = (40.0, 70.0), 50.0, 0.04
CUT = ["events.break.breaks=rope", "events.break.place=[40 m, 70 m]"]
PULLED = "lines.rope.end.held goes on pulling at the broken piece"
SLOW = ["events.break.time=40 ms", "output.duration=50 ms"]


def study_of(folder, *overrides):
    path = folder / "scene.toml"
    path.write_text(HOOKE)
    return load_study(path, [*overrides])


@pytest.fixture(scope="module")
def parted(tmp_path_factory):
    """A line that parts at two places, a shard each, with histories alone."""
    folder = tmp_path_factory.mktemp("parted")
    study = study_of(folder, *CUT, *SLOW, "output.keep=histories")
    shards, laid = open_study(study, folder / "study", 1)
    assert run_here(shards, laid, Share(), lambda done, total: None) == []
    return shards


def exact(time):
    """Speed (m/s) of an end that is let go, (T0 - F(t)) / (m c), and the way it has gone (m).

    F = T0 cos^2(pi t / (2 T)): the speed is v sin^2(pi t / (2 T)), the way its integral.
    """
    t = np.minimum(time, OVER)
    speed = SPEED * np.sin(0.5 * np.pi * t / OVER) ** 2
    way = SPEED * (0.5 * t - OVER / (2.0 * np.pi) * np.sin(np.pi * t / OVER))
    return speed, way + SPEED * (time - t)


def test_broken_ends_move_as_the_exact_wave_until_it_comes_back(parted):
    with open_result(parted.path) as result:
        time = result.time
        speed, way = exact(time)
        for run, place in enumerate(BREAKS):
            before = time < 2.0 * min(place, 100.0 - place) / 1000.0
            for line, side, sign in (("rope-1", "end", -1.0), ("rope-2", "start", 1.0)):
                found = [
                    result.line(line).field(f"{side}_{k}", run) for k in ("position", "velocity")
                ]
                (x, v), aside = (f[before, 0] for f in found), [f[:, 1:] for f in found]
                # 5 % of stretch; a mesh of h leaves (h / length of the front)^2 of what moves
                np.testing.assert_allclose(
                    x, 1.05 * place + sign * way[before], rtol=0, atol=2.5e-3 * way.max()
                )
                np.testing.assert_allclose(v, sign * speed[before], rtol=0, atol=2.5e-3 * SPEED)
                assert not np.any(aside)
        assert result.line("rope-1").fields == [
            "end_position", "end_tension", "end_velocity", "start_tension"
        ]  # fmt: skip
        assert result.written.tolist() == [51, 51]


def test_they_have_names_and_units_and_sum_up_to_the_run_s_numbers(parted):
    result = lumpedcable.open(parted.path)
    line = result.line("rope-2")
    assert line.start_position.dims == line.start_velocity.dims == ("run", "time", "xyz")
    assert (line.start_position.units, line.start_velocity.units) == ("m", "m/s")
    gone = line.start_position - line.start_position.isel(time=0)
    way = np.sqrt((gone**2).sum("xyz").isel(time=-1))
    np.testing.assert_allclose(way, result.summary("rope-2.start").end_displacement, rtol=1e-12)
    assert "start_velocity" in describe(parted.path)


def test_what_reads_histories_reads_them(parted, tmp_path):
    (made,) = export_result(parted.path, "csv", tmp_path / "r.csv")
    head, *rows = csv.reader(made.read_text().splitlines())
    with open_result(parted.path) as result:
        v = result.line("rope-1").field("end_velocity")[..., 0]
    column = head.index("lines/rope-1/end_velocity/x [m/s]")
    np.testing.assert_array_equal(np.array([row[column] for row in rows], float), v.ravel())
    figures = figures_of(parted.path)

    def drawn(name):
        (ax,) = figures[name].axes
        curves = [line.get_ydata() for line in ax.get_lines()]
        return [values for values in curves if len(values) == len(v[0])]

    np.testing.assert_array_equal(drawn("end_speed_rope-1.end"), np.abs(v))
    # it only ever goes one way, along x
    with open_result(parted.path) as result:
        x = result.line("rope-2").field("start_position")[..., 0]
    np.testing.assert_array_equal(drawn("end_displacement_rope-2.start"), x - x[:, :1])


def test_with_fields_they_are_the_end_nodes_own(tmp_path):
    target = tmp_path / "r.h5"
    (outcome,) = run_study(study_of(tmp_path, "output.duration=10 ms"), target)
    assert PULLED not in outcome.message  # the force that held it is gone
    with open_result(target) as result:
        line = result.line("rope")
        np.testing.assert_array_equal(line.field("end_position"), line.position()[:, :, -1])
        np.testing.assert_array_equal(line.field("end_velocity"), line.velocity()[:, :, -1])
        assert not line.has("start_position")  # it holds
    told = {h["key"]: h["words"] for h in recorded(target)["histories"]}
    assert told["lines/rope/end_position/x"] == "position of the end, x"
    assert "lines/rope/end_velocity/y" not in told  # it cannot move so


def test_summaries_hold_none(tmp_path):
    study = study_of(tmp_path, "output.duration=10 ms", "output.keep=summaries")
    run_study(study, tmp_path / "r.h5")
    with open_result(tmp_path / "r.h5") as result:
        assert not result.line("rope").fields


def test_a_force_that_takes_the_broken_piece_along_is_told(parted):
    with open_result(parted.path) as result:
        assert all(PULLED in words for words in result.status_message)


@pytest.mark.slow  # as after a break along it
def test_a_force_that_takes_the_whole_line_along_is_told(tmp_path):
    (outcome,) = run_text(tmp_path, ROPE, "break.breaks=rope.start").outcomes
    assert PULLED in outcome.message


@pytest.mark.slow
def test_a_run_that_ends_where_it_breaks_has_no_numbers_of_its_end(tmp_path):
    # stretched by 15 % of at most 10 % from the start on; what only begins to move has a speed of 0
    held = 'held = { pretension = "50 kN", direction = [1, 0, 0] }'
    text = HOOKE.replace(held, "fixed = [105, 0, 0]").replace("EA =", "max_strain = 0.1\nEA =")
    swept = '[sweep]\n"lines.rope.end.fixed.0" = [105, 115]\n"events.break.start" = [0, "3.5 ms"]\n'
    (tmp_path / "scene.toml").write_text(text + swept)
    study = load_study(tmp_path / "scene.toml", ["output.duration=8 ms", "output.keep=summaries"])
    folder, laid = open_study(study, tmp_path / "s", 4)
    assert run_here(folder, laid, Share(), lambda done, total: None) == []
    with open_result(folder.path) as result:
        assert result.status == ["ok", "ok", "strain_exceeded", "strain_exceeded"]
        assert result.status_time[2:].tolist() == [0.0, 0.0]
        end = result.summary()["rope.end"]
    for name in ("peak_end_speed", "reach", "end_displacement"):
        assert np.isfinite(end[name]).tolist() == [True, True, False, False]
    assert np.all(end["peak_end_speed"][:2] > 50.0)
    np.testing.assert_allclose(end["static_strain"], [0.05, 0.05, 0.15, 0.15])


def test_a_run_of_one_step_has_numbers_of_its_end(tmp_path):
    # breaks at 0 and goes on: one step is enough for a speed
    study = study_of(tmp_path, "output.duration=1 ms", "output.keep=summaries")
    (outcome,) = run_study(study, tmp_path / "result.h5")
    assert outcome.status.name == "OK"
    assert outcome.recoils["rope.end"]["peak_end_speed"] > 0.0
    assert outcome.recoils["rope.end"]["reach"] > 0.0
