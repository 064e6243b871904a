"""Runs that go wrong say so, say why, and leave the others of their batch alone."""

import numpy as np
import pytest
from command_line import say
from engine_runs import HOOKE, ROPE, run_text

from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.bodies import STEEP
from lumpedcable.status import ADVICE, MEANING, Status
from lumpedcable.study.plan import common_coordinates

STIFFENS = """
[materials.steep]
law = "polynomial"
coefficients = ["1 MN", 0, "4 GN"]
max_strain = {reach}

[lines.rope]
material = "steep"
length = "100 m"
segments = 50
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = [101, 0, 0], velocity = ["60 m/s", 0, 0] }} }}

[output]
duration = "400 ms"
every = "2 ms"
"""


def test_every_status_has_a_meaning_and_advice():
    assert set(MEANING) == set(ADVICE) == set(Status)
    assert all(ADVICE[s] for s in Status if s is not Status.OK)


@pytest.mark.slow
def test_a_law_that_stiffens_beyond_its_bound(tmp_path):
    # T' = 1 MN + 12 GN e^2; the end is pulled 24 m away in 400 ms, to 25 % strain, where waves run
    # at sqrt(751 MN / 1 kg/m) = 27 km/s, while the step was chosen for 5 %: 5.6 km/s
    ran = run_text(tmp_path, STIFFENS.format(reach=0.05))
    (outcome,) = ran.outcomes
    assert outcome.status is Status.STEP_BOUND_BROKEN
    assert 0.0 < outcome.status_time < 0.4
    assert "max_strain" in outcome.message
    assert "lower solver.courant" in outcome.message
    # where the scene gives its step, that is what can be lowered; 0.2 ms are 2 m of 1 km/s
    given = STIFFENS.format(reach=0.05) + '[solver]\nstep = "0.2 ms"\n'
    (stepped,) = run_text(tmp_path, given).outcomes
    assert stepped.status is Status.STEP_BOUND_BROKEN
    assert "lower solver.step" in stepped.message
    assert "courant" not in stepped.message
    # told the truth about its reach, it runs
    fine = run_text(tmp_path, STIFFENS.format(reach=0.3))
    assert fine.statuses == ["OK"]
    assert np.max(fine["strain"]) > 0.24


def test_energy_from_nowhere(tmp_path):
    # pulled this fast the stiffening line shocks; without viscosity the front leaves noise, and a step
    # close to its bound feeds that noise
    plain = STIFFENS.format(reach=0.3) + '[solver]\nwaves = "plain"\n'
    ran = run_text(tmp_path, plain)
    (outcome,) = ran.outcomes
    assert outcome.status is Status.ENERGY_NOT_CLOSED
    assert outcome.energy_closure > 0.05
    assert 0.0 < outcome.status_time <= 0.4
    assert "courant" in outcome.message
    # the account before that time is within the limit
    before = ran.time < outcome.status_time
    assert np.max(np.abs(outcome.residual[before])) <= 0.05 * outcome.released_energy
    # with its viscosity it closes to a thousandth
    (fine,) = run_text(tmp_path, STIFFENS.format(reach=0.3)).outcomes
    assert fine.status is Status.OK
    assert fine.energy_closure < 1e-3


def test_a_start_that_cannot_balance(tmp_path):
    # two forces of different size on the two ends of a line
    pull = 'start = { held = { pretension = "40 kN", direction = [-1, 0, 0] } }'
    ran = run_text(tmp_path, HOOKE.replace("start = { fixed = [0, 0, 0] }", pull))
    (outcome,) = ran.outcomes
    assert outcome.status is Status.STATICS_NOT_CONVERGED
    assert outcome.static_imbalance > 0.1
    assert "balance" in outcome.message
    # a run without a start has no history
    assert np.all(np.isnan(ran["position"]))
    assert np.all(np.isnan(ran["velocity"]))
    assert all(np.all(np.isnan(term)) for term in ran.energy.values())
    assert np.isnan(
        [value for name, value in outcome.recoils["rope.end"].items() if name != "break_start"]
    ).all()


@pytest.mark.slow
def test_a_solver_that_runs_out_of_steps(tmp_path):
    ran = run_text(tmp_path, HOOKE + '\n[solver]\nmethod = "tsit5"\nmax_steps = 5\n')
    assert ran.outcomes[0].status is Status.TOO_MANY_STEPS
    assert "max_steps" in ran.outcomes[0].message


FALLS = """
gravity = "9.81 m/s2"
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = "10 m"
segments = 8
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = "free"
[events.break]
breaks = "rope.start"
time = 0
[output]
duration = "0.3 s"
every = "0.02 s"
quantities = ["tension"]
[solver]
method = "kvaerno3"
"""


@pytest.mark.slow  # an implicit method is long to compile
def test_a_step_that_is_not_found_however_short_ends_the_run(tmp_path):
    # the viscosity of a segment is 0 where its ends move alike but for 1e-7 c: a rate that is driven out
    # of that by the rest and back by the viscosity stays at the jump, and a stage there has no solution
    (outcome,) = run_text(tmp_path, FALLS).outcomes
    assert outcome.status is Status.STEP_NOT_FOUND
    assert 0.0 < outcome.status_time <= 0.3
    assert "solver.waves" in outcome.message
    assert "max_steps" not in outcome.message


@pytest.mark.parametrize(
    "change",
    [
        ("output.duration=1e12", "output.every=1e11"),  # at 1000 m/s and 2 m: 5e14 steps
        ("lines.rope.mass=1e-30",),  # 1e18 m/s
        ("materials.hooke.EA=1e60",),  # 1e30 m/s: more steps than an integer holds
        ("solver.step=1e-300",),
        ("solver.step=1e-320",),
    ],
)
def test_a_run_that_would_never_end_is_not_begun(tmp_path, change):
    ran = run_text(tmp_path, HOOKE, *change)
    (outcome,) = ran.outcomes
    assert outcome.status is Status.TOO_MANY_STEPS
    assert "output.duration" in outcome.message
    assert np.isnan(outcome.energy_closure)
    assert np.all(np.isnan(ran["position"]))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("solver.step=1e-300", "1e+299 of 1e-300 s (solver.step), at most 1e+10 are taken; raise "
         "solver.step, or lower output.duration"),
        ("solver.step=[1e-300]", "1e+299 of 1e-300 s (solver.step)"),
        ("solver.courant=1e-300", "5e+301 of 2e-303 s (solver.courant, 1e-300, of the largest stable "
         "one), at most 1e+10 are taken; raise solver.courant, check stiffness"),
        ("solver.courant=[1e-300]", "(solver.courant, 1e-300, of the largest stable one)"),
        ("grading=1e-300", "take longer segments (lines.rope.grading shortens them)"),
    ],
)  # fmt: skip
def test_what_set_a_step_that_is_too_short_is_named(tmp_path, change, words):
    (outcome,) = run_text(tmp_path, HOOKE, change).outcomes
    assert words in outcome.message


def test_the_others_go_on_beside_a_run_that_would_never_end(tmp_path):
    # the second needs 1e15 times the steps of the others
    swept = '\n[sweep]\n"lines.rope.mass" = [1.0, 1e-30, 2.0]\n'
    mixed = run_text(tmp_path, HOOKE + swept, "output.duration=10 ms")
    clean = run_text(tmp_path, HOOKE + swept.replace("1e-30", "4.0"), "output.duration=10 ms")
    assert mixed.statuses == ["OK", "TOO_MANY_STEPS", "OK"]
    for k in (0, 2):
        np.testing.assert_allclose(mixed["velocity"][k], clean["velocity"][k], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("first", ["rope", "other"])
def test_the_line_that_piles_up_is_named(tmp_path, first):
    cut = ROPE.replace("tension_only = false", "tension_only = true").replace("breaks =", "breaks=")
    lines = cut[cut.index("[lines.rope]") : cut.index("[events")]
    other = lines.replace("lines.rope", "lines.other").replace("[0, 0, 0]", "[0, 0, 9]")
    text = cut.replace("[events", f"{other}[events").replace("rope.end", f"{first}.end")
    changes = [f"lines.{first}.end.held.pretension=450 kN", "output.duration=120 ms"]
    (outcome,) = run_text(tmp_path, text, *changes).outcomes
    assert outcome.status is Status.LINE_REVERSED
    assert outcome.message.startswith(f"{first} reversed")
    assert f"materials.nylon.damping and lines.{first}.drag" in outcome.message


@pytest.mark.slow
def test_energies_beyond_all_numbers(tmp_path):
    # m g z of the second line is more than a float holds, though it moves as the first does
    lines = HOOKE[HOOKE.index("[lines.rope]") : HOOKE.index("[events")]
    other = lines.replace("lines.rope", "lines.other").replace("[0, 0, 0]", "[0, 0, 1e308]")
    scene = "gravity = 9.81\n" + HOOKE.replace("[events", f"{other}[events")
    ran = run_text(tmp_path, scene, "output.duration=5 ms")
    (outcome,) = ran.outcomes
    assert outcome.status is Status.NON_FINITE
    assert outcome.status_time == 0.0
    assert "places" in outcome.message


GOOD, BAD = "50 kN", "450 kN"


def batch(*pretensions):
    cut = ROPE.replace("tension_only = false", "tension_only = true")
    listed = ", ".join(f'"{p}"' for p in pretensions)
    return f'{cut}\n[sweep]\n"lines.rope.end.held.pretension" = [{listed}]\n'


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """A run that goes wrong between two that do not."""
    folder = tmp_path_factory.mktemp("mixed")
    return run_text(folder, batch(GOOD, BAD, "90 kN"), "output.duration=120 ms")


def test_a_line_that_piles_up_at_the_wall(mixed):
    # 450 kN without drag: the whole line arrives at the wall at up to 229 m/s, nothing slows it
    # down, and it goes through itself. The front arrives at 58.4 ms: before that all is well
    outcome = mixed.outcomes[1]
    assert outcome.status is Status.LINE_REVERSED
    assert 58.4e-3 < outcome.status_time < 100e-3
    assert outcome.message.startswith(
        "rope reversed on itself, so that the result depends on the mesh at "
    )
    assert "materials.nylon.damping and lines.rope.drag" in outcome.message
    # it says when, and numbers that only hold for a whole run are not given
    numbers = outcome.recoils["rope.end"]
    assert np.isnan(numbers["end_displacement"])
    assert numbers["front_arrival"] == pytest.approx(58.4e-3, rel=0.03)
    before = mixed.time < outcome.status_time
    assert np.min(mixed["strain"][1, before]) > -1.0
    # what it had come to until then it keeps: the end had flown one way, fastest at some step
    end = mixed["position"][1, before, -1]
    assert numbers["reach"] == pytest.approx(np.linalg.norm(end[-1] - end[0]), rel=1e-9)
    fastest = np.max(np.linalg.norm(mixed["velocity"][1, before, -1], axis=1))
    assert fastest <= numbers["peak_end_speed"] < 1.01 * fastest


def test_a_bad_run_leaves_the_others_bit_for_bit_alone(mixed, tmp_path):
    clean = run_text(tmp_path, batch(GOOD, "110 kN", "90 kN"), "output.duration=120 ms")
    assert mixed.statuses == ["OK", "LINE_REVERSED", "OK"]
    assert clean.statuses == ["OK"] * 3
    for k in (0, 2):
        for quantity in ("position", "velocity", "tension", "start_tension"):
            np.testing.assert_array_equal(mixed[quantity][k], clean[quantity][k])
        for term in mixed.energy:
            np.testing.assert_array_equal(mixed.energy[term][k], clean.energy[term][k])
        assert mixed.outcomes[k].recoils == clean.outcomes[k].recoils


def test_a_run_does_not_depend_on_its_company(mixed, tmp_path):
    # alone or among others: one program each, equal to the last digits of a sum
    alone = run_text(tmp_path, batch("90 kN"), "output.duration=120 ms")
    np.testing.assert_allclose(alone["position"][0], mixed["position"][2], rtol=0, atol=1e-11)
    np.testing.assert_allclose(alone["tension"][0], mixed["tension"][2], rtol=0, atol=1e-7)
    assert alone.outcomes[0].steps == mixed.outcomes[2].steps


PITCHED = """
{}
[materials.thread]
law = "linear"
EA = "1 N"
[lines.thread]
material = "thread"
length = "10 m"
segments = 1
mass = "1 g/m"
start = {{ fixed = [0, 0, 10] }}
end = "b"
[bodies.b]
mass = "100 kg"
position = [0, 0, 0]
inertia = [10, 20, 15]
{}
[output]
duration = "2 s"
every = "50 ms"
[solver]
step = "5 ms"
"""


@pytest.mark.slow
def test_a_body_in_space_that_pitches_to_90_degrees_says_so(tmp_path):
    # a moment M about its own y turns it by M t^2 / (2 I): through 90 degrees, given time
    M, I = 40.0, 20.0
    text = PITCHED.format("dimensions = 3", f'control.moment = [0, "{M} N m", 0]')
    ran = run_text(tmp_path, text)
    (outcome,) = ran.outcomes
    assert outcome.status is Status.BODY_UPENDED
    reaches = np.sqrt(2.0 * I * np.arccos(STEEP) / M)
    assert reaches <= outcome.status_time < reaches + 0.05 + 0.005
    assert "axes" in outcome.message
    before = ran.time < reaches
    pitch = ran.bodies["b"]["attitude"][0, before, 1]
    assert pitch == pytest.approx(M / I * ran.time[before] ** 2 / 2, abs=2e-2)


@pytest.mark.parametrize(
    ("dimensions", "body", "refused"),
    [
        ("dimensions = 3", 'attitude = [0, "90 deg", 0]', True),
        ("dimensions = 3", 'attitude = [0, "-88 deg", "20 deg"]', True),
        ("dimensions = 3", 'attitude = [0, "80 deg", 0]', False),
        # these have no roll and yaw to be told apart
        ("dimensions = 3", 'attitude = [0, "90 deg", 0]\nfree = ["x", "z", "pitch", "yaw"]', False),
        ("dimensions = 2", 'attitude = [0, "90 deg", 0]\npoints.p = [1, 0, 1]', False),
    ],
)
def test_a_start_at_90_degrees_of_pitch_is_refused_in_space(tmp_path, dimensions, body, refused):
    path = tmp_path / "scene.toml"
    path.write_text(PITCHED.format(dimensions, body))
    study = load_study(path)
    if not refused:
        assert common_coordinates(study, list(study.runs)).dimensions == int(dimensions[-1])
        return
    with pytest.raises(SceneError, match=r"attitude: expected a pitch more than 6 degrees off"):
        common_coordinates(study, list(study.runs))
    checked = say(tmp_path, "check", path)
    assert (checked.code, "bodies.b.attitude" in checked.err) == (2, True)
