"""What `check --steps` foretells is what runs take; what is said of many runs alike is said once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import say
from engine_runs import HOOKE, study_of

from lumpedcable.results import open_result
from lumpedcable.results.human import runs_named, same_words
from lumpedcable.scene import load_study
from lumpedcable.study.prospect import prospect_lines, prospect_of
from lumpedcable.study.run import run_study

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
QUICK = ["segments=20", "output.duration=20 ms"]
TWO = ["pretension=[45e3, 450e3]", "break.time=0"]  # of the eight runs


def lines_of(*changes: str, scene: Path = SNAPBACK, most: int = 1000) -> list[str]:
    return prospect_lines(prospect_of(load_study(scene, [*QUICK, *changes]), most))


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param((), marks=pytest.mark.slow),
        ("solver.step=0.5 ms",),
        pytest.param(("solver.method=rk4",), marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_steps_are_those_that_are_taken(tmp_path, changes):
    study = load_study(SNAPBACK, [*QUICK, *TWO, *changes])
    found = prospect_of(study, 1000)
    outcomes = run_study(study, tmp_path / "r.h5")
    assert found.steps.tolist() == [one.steps for one in outcomes]
    taken = [one.solver_step for one in outcomes]
    np.testing.assert_allclose(0.02 / found.steps, taken, rtol=1e-12)
    told = "\n".join(prospect_lines(found))
    assert "at rest: 2 of 2 runs" in told
    low, high = sorted(int(one.steps) for one in outcomes)
    assert f"{low} a run" in told if low == high else f"{low} to {high} a run" in told
    assert f"{low + high} in all" in told


def test_bound_is_that_of_a_chain():
    # of a chain of n springs of stiffness EA/l between masses m l: 2/omega, the highest omega of it
    # 2 sqrt(EA/m)/l sin((n - 1) pi/(2 n)) where both ends are held, which is below 2 sqrt(EA/m)/l
    scene = CONFIGS / "hard" / "break-at-once.toml"
    study = load_study(scene, ["segments=50"])
    found = prospect_of(study, 1)
    line = next(iter(study.scene.lines.values()))
    material = study.scene.materials[line.material]
    strain = np.linspace(0.0, material.max_strain, 2001)
    stiffness = np.max(np.gradient(material.curve(strain), strain))
    least = line.length / 50 * np.sqrt(line.mass / stiffness)
    assert found.bound[0] == pytest.approx(least, rel=0.02)


def test_only_the_first_runs_are_looked_at():
    told = lines_of(most=3)
    assert told[0] == "at rest: 3 of the first 3 runs"
    assert "in all" not in told[1]


def test_a_run_without_a_state_of_rest_is_named():
    found = prospect_of(load_study(SNAPBACK, QUICK), 1000)
    lost = found.converged.copy()
    lost[[1, 2]] = False
    told = prospect_lines(replace(found, converged=lost))
    assert told[0].startswith("at rest: 6 of 8 runs; not runs 1 and 2: largest force left ")
    assert told[0].endswith(" of the largest in the scene")
    assert "in all" not in told[1]
    assert len(prospect_lines(replace(found, converged=np.zeros(8, bool)))) == 1


def test_adaptive_static_stopped_and_too_long(tmp_path):
    adaptive = lines_of("solver.method=tsit5")
    assert adaptive[1] == "steps: tsit5, by their estimated error (rtol 1e-06, atol 1e-08)"
    assert adaptive[2].startswith("step: the largest stable one of leapfrog is ")
    head, events = HOOKE.partition("[events")[::2]
    assert events
    static = prospect_of(study_of(tmp_path, head + "[output]\n"), 2)
    assert prospect_lines(static)[1] == "steps: none, the scene is looked at at rest alone"
    stops = load_study(CONFIGS / "restraint.toml")  # when the ship does
    stopped = replace(prospect_of(load_study(SNAPBACK, QUICK), 1), study=stops)
    assert prospect_lines(stopped)[1] == "steps: leapfrog, at most 20 a run"
    long = lines_of("solver.step=10 ms", "output.every=10 ms")
    assert long[2].endswith("of the largest stable one at rest: too long, lower solver.step")
    endless = lines_of("solver.step=1e-15 s")
    assert endless[1].startswith("run 0: more steps are needed than may be taken: it would take")


def test_steps_are_bounded_by_what_relaxes_for_methods_that_it_bounds(tmp_path):
    branch = "materials.hooke.relaxation={fast={EA='10 kN', time='0.1 ms'}}"
    rk4 = study_of(tmp_path, HOOKE, branch, "solver.method=rk4")
    told = prospect_lines(prospect_of(rk4, 1))
    # 0.8 of 0.1 ms: 13 to an output of 1 ms; leapfrog follows it at any step
    assert told[1].startswith("steps: rk4, 1,300 a run")
    assert told[2].endswith("of the largest stable one at rest")
    leapfrog = study_of(tmp_path, HOOKE, branch)
    assert prospect_lines(prospect_of(leapfrog, 1))[1].startswith("steps: leapfrog, 100 a run")


def test_a_step_too_long_from_the_start_is_told_once(tmp_path):
    arguments = [*QUICK, *TWO, "solver.step=10 ms", "output.every=10 ms"]
    options = [word for one in arguments for word in ("--set", one)]
    said = say(tmp_path, "run", SNAPBACK, *options, "-o", "r.h5")
    assert said.code == 1
    assert said.out.count("the step is too long: 10 ms; up to") == 1
    assert "runs 0 and 1: " in said.out
    with open_result(tmp_path / "r.h5") as file:
        assert set(file.status) == {"step_bound_broken"}


def test_the_command(tmp_path):
    options = [word for one in QUICK for word in ("--set", one)]
    said = say(tmp_path, "check", SNAPBACK, *options, "--steps")
    assert said.code == 0
    ok, rest, steps, step = said.out.splitlines()
    assert ok.endswith("ok, 8 runs")
    assert (rest, steps) == ("at rest: 8 of 8 runs", "steps: leapfrog, 20 a run, 160 in all")
    assert step.startswith("step: 1 ms, ")


def test_runs_are_named():
    assert runs_named([3]) == "run 3"
    assert runs_named([0, 1]) == "runs 0 and 1"
    assert runs_named([0, 2, 5, 6, 7]) == "runs 0, 2 and 5 to 7"
    assert runs_named(list(range(0, 40, 2))) == "runs 0, 2, 4, 6, 8, 10, 12 and 13 more"
    assert runs_named(list(range(0, 16, 2))) == "runs 0, 2, 4, 6, 8, 10, 12 and 14"
    told = [(0, "a"), (1, "b"), (2, "a"), (4, "b")]
    assert same_words(told) == [([0, 2], "a"), ([1, 4], "b")]
