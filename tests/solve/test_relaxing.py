"""Lines whose material relaxes, beside exact waves, each other and an elastic line."""

import re
from pathlib import Path

import numpy as np
import pytest
from engine_runs import HOOKE, line_text, run_scenes, run_text, study_of
from relaxing_ropes import BRANCHES, NYLON, PARTING, nylon, relaxing
from scipy.integrate import quad
from scipy.optimize import brentq

from lumpedcable.exact import RelaxingRelease
from lumpedcable.scene import SceneError, load_study


@pytest.mark.parametrize(
    "method", ["leapfrog", "rk4", pytest.param("tsit5", marks=pytest.mark.slow)]
)
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
@pytest.mark.slow
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


@pytest.mark.slow
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
    line = line_text("rope", "rope", 10.0, 2, 1.0, "{ fixed = [0, 0, 0] }", '"free"')
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
