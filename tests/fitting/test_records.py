"""Records of tests: what the fit sees is what a run gives; numbers come back; exact shares."""

import json

import numpy as np
import pytest
from command_line import ROOT, refused, say
from engine_runs import HOOKE, keep_blocks_alone, run_text, study_of
from fit_files import fit_of

from lumpedcable.fitting.observe import grid_of
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.scalar import read_scalar, usual_scalar
from lumpedcable.fitting.sensitivity import sensitivity_of
from lumpedcable.fitting.write import write_fit
from lumpedcable.scene import Scene

# Hooke's law without weight or drag: c = sqrt(EA/m) = 1000 m/s, speed of the end F0/sqrt(EA m) = 50 m/s
LINE = HOOKE.replace("segments = 50", "segments = 10").replace('"100 ms"', '"60 ms"')
LINE += '[solver]\nwaves = "plain"\n'
RECORD = """
[experiments.{name}]
file = "{name}.csv"
set = {{ pretension = "{pull} kN" }}
time = {{ column = "t", unit = "ms" }}
observe = [
    {{ quantity = "velocity", at = "rope.end", component = "x", column = "v" }},
    {{ quantity = "tension", at = "rope@35 m", column = "T", unit = "kN" }},
    {{ quantity = "position", at = "rope.end", component = "x", column = "x" }},
]
"""
FREE = """scene = "scene.toml"
[free]
"materials.hooke.EA" = { start = "1.3 MN" }
"lines.rope.mass" = { start = "0.8 kg/m" }
"events.break.time" = { start = "4 ms", private = true }
"""


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """Two break tests, run by the engine as a user would, written as data and fitted."""
    folder = tmp_path_factory.mktemp("records")
    text = LINE.replace("time = 0", 'time = "5 ms"')
    runs = {}
    for name, pull, time in (("low", 50, 5), ("high", 80, 6)):
        ran = run_text(folder, text, f"pretension={pull} kN", f"break.time={time} ms")
        # 35 m is the middle of the fourth segment
        tension = ran["tension"][0, :, 3]
        place = ran["position"][0, :, -1, 0]
        runs[name] = (ran.time, ran["velocity"][0, :, -1, 0], tension, place)
        columns = zip(ran.time, runs[name][1], tension, place, strict=True)
        rows = [f"{1e3 * t:.6g},{v!r},{s / 1e3!r},{x!r}" for t, v, s, x in columns]
        rows = [row.replace("np.float64(", "").replace(")", "") for row in rows]
        (folder / f"{name}.csv").write_text("t,v,T,x\n" + "\n".join(rows) + "\n")
    records = RECORD.format(name="low", pull=50) + RECORD.format(name="high", pull=80)
    return fit_problem(fit_of(folder, FREE + records, text).problem), runs


@pytest.mark.slow
def test_what_is_compared_is_what_a_run_gives(fitted):
    found, runs = fitted
    told = [column for name in ("low", "high") for column in runs[name][1:]]
    for model, column in zip(found.predicted, told, strict=True):
        assert model == pytest.approx(column, abs=1e-6 * np.max(np.abs(column)))


def test_shared_and_private_numbers_come_back(fitted):
    found, _ = fitted
    names = [p.name for p in found.problem.parameters]
    assert names == ["materials.hooke.EA", "lines.rope.mass", "events.break.time [low]",
                     "events.break.time [high]"]  # fmt: skip
    assert found.converged
    assert found.values == pytest.approx([1e6, 1.0, 5e-3, 6e-3], rel=1e-6)


def test_the_fitted_scene_runs_and_gives_the_same(fitted, tmp_path):
    found, runs = fitted
    made, wrong = write_fit(found, {}, tmp_path)
    assert not wrong
    assert {p.name for p in made} == {
        "scene-fitted.toml", "scene-low-fitted.toml", "scene-high-fitted.toml", "fit.json"
    }  # fmt: skip
    ran = run_text(tmp_path, (tmp_path / "scene-high-fitted.toml").read_text())
    speed = ran["velocity"][0, :, -1, 0]
    assert speed == pytest.approx(runs["high"][1], abs=1e-5 * np.max(np.abs(speed)))
    told = json.loads((tmp_path / "fit.json").read_text())
    assert [p["value"] for p in told["parameters"]] == pytest.approx(found.values, rel=1e-12)
    std = np.array([p["std"] for p in told["parameters"]])
    covariance = np.array(told["covariance"]["rows"])
    assert covariance == pytest.approx(
        np.array(told["correlation"]["rows"]) * np.outer(std, std), rel=1e-6
    )
    assert told["status"] == "ok"
    assert told["evaluations"] == sum(s["evaluations"] for s in told["searches"]) > 0


def test_times_between_steps_are_met_by_a_cubic():
    for x in (0.2, 1.3, 2.7):
        times = np.array([0.5, 1.1 + 1e-3 * x, 2.0])
        grid = grid_of(times, 0.2)
        assert not grid.exact
        at = grid.every * np.arange(grid.outputs + 1)
        for power in range(4):
            met = np.sum(grid.weight * at[grid.near] ** power, axis=1)
            assert met == pytest.approx(times**power)


@pytest.mark.parametrize(
    ("times", "every"),
    [
        (np.arange(5, 121, 3), 1.0),  # every third row, from the fifth on
        (np.arange(4, 41, 4), 4.0),
        (np.array([3, 10, 20]), 1.0),
        (np.array([100.0, 101.0, 103.5]), 0.5),
    ],
)
def test_thinned_and_later_times_are_output_times_too(times, every):
    grid = grid_of(5e-4 * times, 0.2)
    assert grid.exact
    assert grid.every == pytest.approx(5e-4 * every, rel=1e-12)
    assert grid.every * grid.near[:, 0] == pytest.approx(5e-4 * times, rel=1e-9)


def assert_shares(share):
    # by dimensions, and for the lumped line in time steps as well: v = F0/sqrt(EA m) g(EA/m), whatever
    # g does, so that the shares of EA and m add up to -1 and that of F0 is 1
    assert share["lines.rope.end.held.pretension"] == pytest.approx(1.0, rel=1e-9)
    assert share["materials.hooke.EA"] + share["lines.rope.mass"] == pytest.approx(-1.0, rel=1e-9)
    assert share["materials.hooke.EA"] < 0.0 > share["lines.rope.mass"]
    assert list(np.abs(list(share.values()))) == sorted(np.abs(list(share.values())), reverse=True)


SLOW_BREAK = LINE.replace("time = 0", 'time = "20 ms"')


def test_shares_of_the_exact_speed_by_the_command(tmp_path):
    (tmp_path / "scene.toml").write_text(SLOW_BREAK)
    said = say(tmp_path, "sensitivity", "scene.toml", "-o", "out")
    assert said.code == 0, said.err
    assert "max velocity at rope.end" in said.out
    told = json.loads((tmp_path / "out" / "sensitivity.json").read_text())
    assert told["unit"] == "m/s"
    assert_shares({n["key"]: n["percent_per_percent"] for n in told["numbers"]})
    assert (tmp_path / "out" / "sensitivity.png").exists()


# blocks of some outputs, of a part of an output's steps, and all states kept
@pytest.mark.parametrize(
    ("blocks", "every"),
    [(True, "1 ms"), (True, "60 ms"), pytest.param(False, "2 ms", marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_shares_of_the_exact_speed_in_reverse(monkeypatch, tmp_path, blocks, every):
    if blocks:
        keep_blocks_alone(monkeypatch)
    study = study_of(tmp_path, SLOW_BREAK, f"output.every={every}")
    assert str(usual_scalar(study.scene)) == "max velocity at rope.end"
    found = sensitivity_of(
        study, read_scalar("max velocity at rope.end", study.scene), reverse=True
    )
    assert_shares(dict(zip(found.keys, found.shares, strict=True)))


TARGET = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "wire"
length = "30 m"
segments = 4
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = [28, 0, 0] }
[targets.pull]
change = "lines.rope.length"
of = "rope.end"
tension = "4 kN"
[output]
"""


@pytest.mark.slow
def test_what_a_target_asks_for_is_what_the_result_depends_on(tmp_path):
    # the tension at the end is the target's, whatever the rope is: derivative 1, all others 0
    study = study_of(tmp_path, TARGET)
    found = sensitivity_of(study, read_scalar("last tension at rope.end", study.scene))
    assert found.value == pytest.approx(4e3, rel=1e-6)
    slopes = dict(zip(found.keys, found.slopes, strict=True))
    assert slopes.pop("targets.pull.tension") == pytest.approx(1.0, rel=1e-6)
    assert list(found.shares[1:]) == pytest.approx([0.0] * len(slopes), abs=1e-6)


TRANSFER = ROOT / "configs" / "highline" / "transfer.toml"


@pytest.mark.slow
def test_a_measure_of_a_transfer_does_not_depend_on_the_unit_of_mass(tmp_path):
    # a height has no mass in it: shares of masses, forces and stiffnesses add up to 0; through rk4, an
    # ideal cable, a trolley and a winch
    said = say(tmp_path, "sensitivity", TRANSFER, "--of", "min h_w", "--set", "duration=10 s")
    assert said.code == 0, said.err
    told = json.loads((tmp_path / "transfer" / "sensitivity.json").read_text())
    shares = {n["key"]: n["percent_per_percent"] for n in told["numbers"]}
    assert told["unit"] == "m"
    assert shares["lines.highline.end.winch.tension"] > 0.1 > -0.1 > shares["bodies.cargo.mass"]
    massive = [k for k in shares if k.endswith((".mass", ".EA", "winch.tension"))]
    assert sum(shares[k] for k in massive) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("of", "said"),
    [("min h_q", 'expected a measure of the scene, found "h_q"; did you mean'),
     ("max tension at highline.start", 'expected a line with nodes, found "highline", which is ideal')],
)  # fmt: skip
def test_a_scalar_that_a_scene_does_not_have(tmp_path, of, said):
    told = refused(tmp_path, "sensitivity", TRANSFER, "--of", of)
    assert said in told


@pytest.mark.parametrize(
    ("text", "said"),
    [("peak speed", "expected \"max velocity at LINE.end\""), ("mox velocity at a.end", '"max"'),
     ("max speed at rope.end", "tension, displacement, velocity, position"),
     ("max position at rope.end", "expected a component"),
     ("max tension at rope.end in x", "none for a tension")],
)  # fmt: skip
def test_a_scalar_that_is_none(text, said):
    with pytest.raises(ValueError, match="expected") as told:
        read_scalar(text, Scene.model_construct(measures={}))
    assert said in str(told.value)


@pytest.mark.parametrize(
    ("text", "at", "component"),
    [("max tension at rope@11.3 m", "rope@11.3 m", None),
     ("last position at rope@11.3 m in z", "rope@11.3 m", "z"),
     ("last position at  rope@11.3m  in z", "rope@11.3m", "z"),
     ("last position at rope@1e3 in in x", "rope@1e3 in", "x"),
     ("max velocity at rope@445 in", "rope@445 in", None),
     ("max velocity at rope@11 in y", "rope@11", "y")],
)  # fmt: skip
def test_a_place_of_a_scalar_may_have_a_blank_before_its_unit(text, at, component):
    found = read_scalar(text, Scene.model_construct(measures={}))
    assert (found.at, found.component) == (at, component)
