"""Lines whose material relaxes, beside closed forms and an integration of their own equations."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from engine_runs import HOOKE, line_text, nylon_rope, run_scenes, run_text, study_of
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from lumpedcable.exact import RelaxingRelease
from lumpedcable.scene import SceneError, load_study

LONG, SWING, PERIOD = 10.0, 0.5, 0.2  # m, m, s
OMEGA = 2.0 * np.pi / PERIOD
BRANCHES = {"fast": (3e5, 0.02), "slow": (2e5, 0.3)}  # N, s


def relaxing(material, branches=BRANCHES):
    """The tables of a material's branches."""
    rows = (
        f"[materials.{material}.relaxation.{name}]\nEA = {stiff}\ntime = {time}\n"
        for name, (stiff, time) in branches.items()
    )
    return "".join(rows)


def shaken(law, mean, more="", swing=SWING, branches=BRANCHES):
    """One segment, pulled to `mean` (m), whose far end is moved to and fro by `swing` (m)."""
    motion = (
        f"{{ motion = {{ position = [{mean}, 0, 0], amplitude = [{swing}, 0, 0], "
        f"period = {PERIOD} }} }}"
    )
    line = line_text("rope", "rope", LONG, 1, 1.0, "{ fixed = [0, 0, 0] }", motion)
    return f"""
[materials.rope]
{law}
{relaxing("rope", branches)}
{line}
[solver]
step = 1e-3
{more}
[output]
duration = 0.6
every = 0.02
"""


ROPE = nylon_rope(50, "150 ms").replace("tension_only = false", "tension_only = true")
PARTING = ROPE.replace('"45 kN"', '"180 kN"').replace(
    "[lines.rope]", relaxing("nylon") + "[lines.rope]"
)


def pulled(t, stiff, time):
    """What a branch carries (N) that is shaken from rest from t = 0 on: storage, loss, and the start."""
    x = OMEGA * time
    swung = np.cos(OMEGA * t) + x * np.sin(OMEGA * t) - np.exp(-t / time)
    return stiff * SWING / LONG * x / (1.0 + x**2) * swung


def test_a_segment_that_is_shaken(tmp_path):
    text = shaken('law = "linear"\nEA = 1e6', 12.0)
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        ran = run_text(tmp_path, text, f"solver.step={step}")
        t = ran.time
        exact = 1e6 * (0.2 + SWING / LONG * np.sin(OMEGA * t))
        exact += sum(pulled(t, *branch) for branch in BRANCHES.values())
        errors.append(np.max(np.abs(ran["tension"][0, :, 0] - exact)))
        assert ran.statuses == ["OK"]
    assert errors[0] < 1e-3 * 5e5 * SWING / LONG
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("method", ["rk4", pytest.param("tsit5", marks=pytest.mark.slow)])
def test_by_other_methods(tmp_path, method):
    text = shaken('law = "linear"\nEA = 1e6', 12.0)
    chosen = () if method == "rk4" else ("solver.rtol=1e-6", "solver.atol=1e-9")
    text = text if method == "rk4" else text.replace("step = 1e-3", "")
    ran = run_text(tmp_path, text, f"solver.method={method}", *chosen)
    t = ran.time
    exact = 1e6 * (0.2 + SWING / LONG * np.sin(OMEGA * t))
    exact += sum(pulled(t, *branch) for branch in BRANCHES.values())
    assert np.max(np.abs(ran["tension"][0, :, 0] - exact)) < 1e-3 * 5e5 * SWING / LONG


NYLON = {"p1": 270.3e3, "p2": 10.2, "p3": -2.128, "p4": 262.7e3, "p5": 135.5}


def nylon(e):
    """The paper's law (N), which is 0.79 kN at a strain of 0."""
    p = NYLON
    return p["p1"] * np.tanh(p["p2"] * e + p["p3"]) + p["p4"] + p["p5"] * e


def folding(times, mean, swing, branches):
    """Tension (N) of a segment of nylon that is shaken and folds, by its own equations."""
    stiff, time = np.array(list(branches.values())).T
    slack = brentq(nylon, -0.5, 0.5)

    def cut(e):
        return max(nylon(e), 0.0) if e > slack else 0.0

    def total(e, s):
        return cut(e) + np.sum(stiff * (e - s))

    def strain(t):
        return mean / LONG - 1.0 + swing / LONG * np.sin(OMEGA * t)

    def rate(t, s):
        e = strain(t)
        if total(e, s) < 0.0:
            e = brentq(total, max(e, slack), np.max(s) + 1e-9, args=(s,))
        return (e - s) / time

    start = np.full(len(stiff), max(strain(0.0), slack))
    found = solve_ivp(
        rate, (0.0, times[-1]), start, t_eval=times, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    return np.array([max(total(strain(t), s), 0.0) for t, s in zip(times, found.y.T, strict=True)])


KEYS = "\n".join(f"{key} = {value}" for key, value in NYLON.items())
# pulled by a few per cent and pushed back, slack half of the time; to where the law bends over, with
# less beside it and with more; slack at rest
FOLDS = [
    (10.3, 0.5, BRANCHES),
    (11.6, 1.8, {"only": (2e5, 2.0)}),
    pytest.param(11.4, 2.0, {"only": (5e5, 2.0)}, marks=pytest.mark.slow),
    (9.7, 0.8, {"only": (3e5, 1000.0)}),
]


@pytest.mark.parametrize(("mean", "swing", "branches"), FOLDS)
def test_a_rope_that_folds(tmp_path, mean, swing, branches):
    law = f'law = "tanh"\n{KEYS}\ntension_only = true'
    text = shaken(law, mean, swing=swing, branches=branches)
    errors = []
    for step in (5e-4, 2.5e-4):
        ran = run_text(tmp_path, text, f"solver.step={step}")
        exact = folding(ran.time, mean, swing, branches)
        assert np.mean(exact == 0.0) > 0.2
        errors.append(np.max(np.abs(ran["tension"][0, :, 0] - exact)))
        assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 2e-3
    assert errors[1] < 1e-3 * np.max(exact)


def test_a_rope_that_is_slack_pulls_once_it_is_taut(tmp_path):
    # its end goes off at 1 m/s; a branch that hardly relaxes is a spring beside that of the law
    motion = "{ motion = { position = [9.8, 0, 0], velocity = [1, 0, 0] } }"
    line = line_text("rope", "rope", LONG, 1, 1.0, "{ fixed = [0, 0, 0] }", motion)
    branch = relaxing("rope", {"only": (3e5, 1e6)})
    text = f"""
[materials.rope]
law = "linear"
EA = 1e6
tension_only = true
{branch}
{line}
[solver]
step = 1e-3
[output]
duration = 0.4
every = 0.05
"""
    ran = run_text(tmp_path, text)
    exact = 1.3e6 * np.maximum(ran.time - 0.2, 0.0) / LONG
    assert ran["tension"][0, :, 0] == pytest.approx(exact, abs=1e-4 * np.max(exact))


def test_single_precision_holds_as_long(tmp_path):
    # a step is a ten-thousandth of a hundredth of the time: what it relaxes has no digit of its own
    motion = (
        "{ motion = { time = [0, 0.1, 0.2, 1], position = "
        "[[10, 0, 0], [10.5, 0, 0], [10.5, 0, 0], [10.5, 0, 0]] } }"
    )
    line = line_text("rope", "rope", LONG, 1, 1.0, "{ fixed = [0, 0, 0] }", motion)
    branch = relaxing("rope", {"only": (2e5, 100.0)})
    text = f"""
[materials.rope]
law = "linear"
EA = 1e6
{branch}
{line}
[solver]
step = 1e-4
dtype = "float32"
[output]
duration = 1
every = 0.1
"""
    ran = run_text(tmp_path, text)
    carried = ran["tension"][0, :, 0] - 1e6 * ran["strain"][0, :, 0]
    assert carried[-1] / carried[2] == pytest.approx(np.exp(-0.8 / 100.0), abs=2e-4)


@pytest.mark.parametrize("method", ["leapfrog", "rk4", "tsit5"])
def test_times_shorter_than_steps(tmp_path, method):
    # leapfrog goes over them, other methods must not; next to a dashpot of 200 N s
    branch = relaxing("hooke", {"only": (2e6, 1e-4)})
    text = HOOKE.replace("[lines.rope]", branch + "[lines.rope]").replace(
        "time = 0\n", "time = 0.02\n"
    )
    ran = run_text(tmp_path, text, f"solver.method={method}", "rope.segments=40", "duration=40 ms")
    wave = RelaxingRelease(100.0, 1e6, 1.0, 50e3, ((2e6, 1e-4),), 0.02)
    exact = wave.velocity(np.linspace(100.0, 0.0, 41), ran.time[:, None])
    assert ran.statuses == ["OK"]
    assert np.mean(np.abs(-ran["velocity"][0, :, :, 0] - exact)) < 1e-3 * np.max(exact)


@pytest.mark.parametrize(
    "pretension", [180e3, *(pytest.param(F, marks=pytest.mark.slow) for F in (45e3, 450e3))]
)
def test_branches_that_do_not_relax_yet_are_part_of_the_law(tmp_path, pretension):
    # within a thousandth of their time the law is T(e) + EA (e - e0), cut at 0, and behind the simple
    # wave of a break in 5 ms, before the wall or a shock knows of it, the end has the integral of c de
    strain = brentq(lambda e: nylon(e) - pretension, 0.0, 0.5)
    stiff = sum(stiff for stiff, _ in BRANCHES.values())
    slack = brentq(lambda e: nylon(e) + stiff * (e - strain), 0.0, 0.5)

    def speed(e):
        bend = NYLON["p2"] / np.cosh(NYLON["p2"] * e + NYLON["p3"]) ** 2
        return np.sqrt((NYLON["p1"] * bend + NYLON["p5"] + stiff) / 2.238)

    frozen = relaxing("nylon", {name: (stiff, 50.0) for name, (stiff, _) in BRANCHES.items()})
    text = PARTING.replace(relaxing("nylon"), frozen).replace('"180 kN"', f"{pretension}")
    ran = run_text(tmp_path, text, "rope.segments=100", "duration=15 ms")
    ends = -ran["velocity"][0, 8:, -1, 0]
    assert np.mean(ends) == pytest.approx(quad(speed, slack, strain)[0], rel=1e-3)


def test_what_is_lost_is_counted(tmp_path):
    # a rope that goes slack behind the wave and stays so: all of its energy goes somewhere
    ran = run_text(tmp_path, PARTING)
    lost, residual = ran.energy["lost_relaxation"][0], ran.energy["residual"][0]
    stored = ran.energy["strain"][0, 0]
    assert ran.statuses == ["OK"]
    assert np.all(np.diff(lost) > 0.0)
    assert 0.05 < lost[-1] / stored < 0.5
    assert np.max(np.abs(residual)) < 1e-3 * stored
    elastic = run_text(tmp_path, PARTING.replace(relaxing("nylon"), ""))
    assert "lost_relaxation" not in elastic.energy


@pytest.mark.slow
def test_branches_that_carry_nothing_change_nothing(tmp_path):
    none = relaxing("nylon", {"fast": (0.0, 0.02)})
    with_none = run_text(tmp_path, PARTING.replace(relaxing("nylon"), none))
    without = run_text(tmp_path, PARTING.replace(relaxing("nylon"), ""))
    moved = np.max(np.abs(without["position"]))
    assert np.max(np.abs(with_none["position"] - without["position"])) < 1e-9 * moved


@pytest.mark.slow
def test_runs_of_a_sweep_are_those_of_single_runs(tmp_path):
    key = "materials.nylon.relaxation.fast.EA"
    both = run_text(tmp_path, PARTING, f"{key}=[1e5, 3e5]")
    assert both["position"].shape[0] == 2
    for run, value in enumerate((1e5, 3e5)):
        alone = run_text(tmp_path, PARTING, f"{key}={value}")
        moved = np.max(np.abs(alone["position"]))
        assert np.max(np.abs(both["position"][run] - alone["position"][0])) < 1e-10 * moved


@pytest.mark.slow
def test_a_break_in_the_middle_is_two_breaks_at_ends(tmp_path):
    # without wave terms, which know of the cut: each half of it is a line of its own
    branch = relaxing("hooke")
    plain = '[solver]\nwaves = "plain"\nstep = 2e-4\n[output]'
    held = '{ held = { pretension = "50 kN", direction = [1, 0, 0] } }'
    text = HOOKE.replace("[lines.rope]", branch + "[lines.rope]").replace("[output]", plain)
    text = text.replace("time = 0\n", 'time = "5 ms"\n')
    half = text.replace('length = "100 m"', 'length = "50 m"').replace(
        "segments = 50", "segments = 25"
    )
    whole = text.replace('breaks = "rope.end"', 'breaks = "rope@50 m"')
    whole = whole.replace(held, "{ fixed = [105, 0, 0] }")
    both, one = run_text(tmp_path, whole), run_text(tmp_path, half)
    for quantity in ("tension", "strain"):
        parted = both[f"rope-1.{quantity}"][0]
        scale = np.max(np.abs(parted))
        assert np.max(np.abs(parted - one[quantity][0])) < 1e-9 * scale
        assert np.max(np.abs(both[f"rope-2.{quantity}"][0][:, ::-1] - parted)) < 1e-9 * scale


@pytest.mark.slow
def test_as_many_dimensions_as_there_are(tmp_path):
    straight = run_text(tmp_path, PARTING)
    text = PARTING.replace("[materials.nylon]", "dimensions = 3\n[materials.nylon]", 1)
    space = run_text(tmp_path, text)
    scale = np.max(straight["tension"])
    early = straight.time < 0.05  # before it goes slack, when a straight line may turn aside
    gap = np.abs(space["tension"] - straight["tension"])[0, early]
    assert space["position"].shape[-1] == 3
    assert np.max(gap) < 1e-9 * scale


def test_arrival_counts_what_relaxes(tmp_path):
    # the front runs with the stiffness of fast loads, and the far end feels it then
    text = HOOKE.replace("[lines.rope]", relaxing("hooke", {"fast": (1e6, 0.2)}) + "[lines.rope]")
    ran = run_text(tmp_path, text, "rope.segments=200")
    assert ran.outcomes[0].recoils["rope.end"]["front_arrival"] == pytest.approx(
        0.1 / np.sqrt(2.0), rel=0.03
    )


SPEED, TURNED = 1.0, [0.0, 0.2, 0.6, 0.8]  # m/s, s


def hauled(times):
    """Tension (N) of 10.3 m that a drum makes of 10 m and less, by the equations of the material."""
    stiff, time = np.array(list(BRANCHES.values())).T

    def strain(t):
        knots = np.unique([0.0, *(x for x in TURNED if x < t), t])
        speed = -SPEED * np.interp(knots, TURNED, [0.0, 1.0, 1.0, 0.0])
        return 10.3 / (LONG + np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(knots))) - 1.0

    found = solve_ivp(
        lambda t, s: (strain(t) - s) / time, (0.0, times[-1]), np.full(2, strain(0.0)),
        t_eval=times, rtol=1e-9, atol=1e-12, max_step=1e-3,
    )  # fmt: skip
    pulls = zip(times, found.y.T, strict=True)
    return np.array([1e6 * strain(t) + stiff @ (strain(t) - s) for t, s in pulls])


def test_a_line_on_a_drum(tmp_path):
    speeds = [0.0, -SPEED, -SPEED, 0.0]
    drum = (
        f"{{ drum = {{ at = [10.3, 0, 0], schedule = {{ time = {TURNED}, speed = {speeds} }} }} }}"
    )
    text = shaken('law = "linear"\nEA = 1e6', 10.3).replace("duration = 0.6", "duration = 1.2")
    start, _, rest = text.partition("end = ")
    ran = run_text(tmp_path, f"{start}end = {drum}\n{rest.partition(chr(10))[2]}")
    exact = hauled(ran.time)
    assert np.max(np.abs(ran["tension"][0, :, 0] - exact)) < 1e-4 * np.max(exact)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow
def test_a_line_on_a_winch_keeps_its_account(tmp_path):
    # the end across is shaken, and the winch pays out and hauls in what keeps its tension
    text = shaken('law = "linear"\nEA = 1e6', 12.0).replace("segments = 1", "segments = 10")
    winch = "{ winch = { at = [0, 0, 0], tension = 5e4, inertia = 50, damping = 2e4 } }"
    text = text.replace("start = { fixed = [0, 0, 0] }", f"start = {winch}")
    text = text.replace("duration = 0.6", "duration = 2").replace("step = 1e-3", "step = 2e-4")
    ran = run_text(tmp_path, text)
    pulled = ran["tension"][0]
    assert ran.statuses == ["OK"]
    assert np.std(pulled) > 0.05 * 5e4
    assert np.mean(pulled[ran.time > 1.0]) == pytest.approx(5e4, rel=0.02)
    lost = ran.energy["lost_relaxation"][0]
    residual = np.max(np.abs(ran.energy["residual"][0]))
    assert residual < 2e-3 * lost[-1]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            "time = 0.02",
            "time = 0",
        ),
        ("EA = 300000.0", "EA = -1"),
        ("EA = 300000.0\n", ""),
    ],
)
def test_branches_are_checked(tmp_path, change, said):
    assert change in PARTING
    with pytest.raises(
        SceneError, match=r"relaxation\.fast\.(EA|time): expected a (positive|non-neg)"
    ):
        study_of(tmp_path, PARTING.replace(change, said, 1))


def test_branches_in_another_order_are_the_same_material(tmp_path):
    turned = PARTING.replace(relaxing("nylon"), relaxing("nylon", dict(reversed(BRANCHES.items()))))
    one, other = (study_of(tmp_path, text).scene.materials["nylon"] for text in (PARTING, turned))
    assert list(one.relaxation) != list(other.relaxation)
    assert one == other
    assert hash(one) == hash(other)


def test_rods_do_not_relax(tmp_path):
    text = 'law = "inextensible"\n' + relaxing("rope")
    line = line_text("rope", "rope", LONG, 2, 1.0, "{ fixed = [0, 0, 0] }", '"free"')
    scene = f"gravity = 9.81\n[materials.rope]\n{text}\n{line}\n[solver]\nstep = 1e-3\n"
    scene += "[output]\nduration = 1\nevery = 0.1\n"
    with pytest.raises(SceneError, match="expected no relaxation of an inextensible material"):
        study_of(tmp_path, scene)


ROOT = Path(__file__).parents[2]
TABLE = re.compile(r"<!-- relaxing -->\n(.*?)<!-- end -->", re.DOTALL)


@pytest.mark.slow
def test_the_page_has_the_numbers_of_the_main_job(tmp_path):
    found = TABLE.search((ROOT / "docs" / "model.md").read_text(encoding="utf-8"))
    assert found is not None
    rows = [line.strip("| ").split(" | ") for line in found[1].splitlines()[2:]]
    printed = np.array([[float(x) for x in row[1:]] for row in rows]).reshape(4, 3, 2)
    branches = "{fast={EA='300 kN', time='20 ms'}, slow={EA='200 kN', time='0.5 s'}}"
    for column, changes in enumerate(([f"materials.nylon.relaxation={branches}"], [])):
        study = load_study(ROOT / "configs" / "snapback.toml", ["break.time=5 ms", *changes])
        ends = [one.recoils["rope.end"] for one in run_scenes(tmp_path, study).outcomes]
        numbers = [
            (end["peak_end_speed"], end["end_displacement"], 1e3 * end["front_arrival"])
            for end in ends
        ]
        assert printed[:, :, column] == pytest.approx(np.array(numbers), rel=2e-4)
