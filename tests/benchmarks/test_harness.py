"""The harness from a scene to the page, on a line of a few segments."""

import json
import math

import numpy as np
import pytest

from benchmarks import everything, figures, headline, report, targets
from benchmarks.cases import MAIN
from benchmarks.engine import Runner, scene_of
from benchmarks.measures import errors
from benchmarks.methods import DEFAULT, METHODS, RK4
from benchmarks.peers import compare, elastica_line, moordyn_line, scipy_line
from benchmarks.problem import line_of
from benchmarks.reference import load
from benchmarks.work_precision import measure
from lumpedcable.status import Status

CASE = next(c for c in MAIN if c.name == "180 kN, 5 ms")
METHOD = {method.name: method for method in METHODS}


@pytest.fixture(scope="module")
def points():
    """The default on two meshes and another method on one, as the report measures them."""
    found = []
    for name, meshes in ((DEFAULT, (8, 16)), (RK4, (8,))):
        found += measure(METHOD[name], meshes, (CASE,), load(), math.inf, lambda _: None)[0]
    return found


@pytest.mark.slow
def test_every_point_carries_what_it_needs(points):
    assert len(points) == 3
    for p in points:
        assert p["status"] == "OK"
        assert p["dtype"] == "float64"
        assert p["warm"] > 0.0
        assert p["steps"] >= 200
        # a mesh of 7.5 or 3.75 m against a front that a 5 ms ramp makes some metres long
        assert 1e-3 < p["errors"]["velocity"] < 0.3
    assert points[1]["errors"]["velocity"] < points[0]["errors"]["velocity"]


def test_seen_more_often_a_run_stays_the_same():
    runner = Runner(scene_of(*CASE.changes, "segments=16"))
    seen, status = runner.histories(runner.every, runner.steps, runner.count)
    fine = runner.fine()
    assert status is Status.OK
    assert fine.displacement == pytest.approx(seen.displacement, rel=1e-12)
    every = round(runner.every / fine.time[1])
    np.testing.assert_allclose(fine.tension[::every], seen.tension, rtol=1e-9)


def test_a_run_that_goes_wrong_is_told():
    scene = scene_of(*CASE.changes, "segments=64", 'solver.waves="plain"')
    runner = Runner(scene, 2.5)
    runner.limit = np.inf
    # steps of 4 ms, over which sound crosses four segments: it blows up
    assert runner.histories(4e-3, 1, 20)[1] in (Status.NON_FINITE, Status.LINE_REVERSED)
    # it is told even before, as soon as a step is too long
    runner.limit = 1.0
    assert runner.histories(runner.every, runner.steps, 20)[1] is Status.STEP_BOUND_BROKEN


def test_runge_kutta_stands_steps_beyond_those_of_leapfrog():
    # (2.83 / 2 of them; 1.35 is asked for)
    runner = Runner(
        scene_of(*CASE.changes, "segments=64", *METHOD[RK4].changes), METHOD[RK4].stretch
    )
    assert runner.histories(runner.every, runner.steps, 200)[1] is Status.OK
    assert runner.steps < Runner(runner.scene).steps


def test_the_report_is_made_of_the_points(points, tmp_path):
    data = {
        "machine": {"processor": "x", "cores": "1", "memory": "1 GiB", "system": "s", "python": "3",
                    "device": "cpu"},
        "quick": True, "seconds": {"work-precision": 1.0},
        "made": {"work-precision": "2000-01-01 00:00"},
        "parts": {"work-precision": {"points": points, "budgets": {RK4: 1.0}, "cut": {RK4: 16}}},
    }  # fmt: skip
    found = report.write(data, tmp_path)
    assert f"Cut off: {RK4} after 1 s at N = 16" in found["cut"]
    table = found["times-velocity-5-ms"].splitlines()
    assert {"1 %, 180 kN", "0.3 %, 180 kN", "0.1 %, 180 kN"} <= set(
        table[0].strip("| ").split(" | ")
    )
    assert len(table) == 4
    # every row of every table has as many cells as its head
    for name, text in found.items():
        rows = [line for line in text.splitlines() if line.startswith("|")]
        assert len({row.count("|") for row in rows}) <= 1, name
    again = report.read(tmp_path)
    assert again["parts"]["work-precision"]["points"][0]["case"] == CASE.name
    assert json.loads((tmp_path / "results.json").read_text())["quick"] is True
    made = figures.draw(data["parts"], tmp_path, "png")
    drawn = ("displacement", "velocity", "tension-fine")
    assert {p.name for p in made} == {f"{name}-5-ms.png" for name in drawn}
    assert all(p.stat().st_size > 10_000 for p in made)


def test_every_method_mesh_and_setting_has_a_row():
    errors_ = {"displacement": 0.01, "velocity": 0.02, "tension": 0.03, "tension_fine": 0.04,
               "front": 1e-3}  # fmt: skip

    def one(case, n, **who):
        return who | {"case": case, "segments": n, "errors": errors_, "warm": 2e-3, "steps": 7}

    points = [
        one(f"{pull} kN, at once", n, method=method)
        for method, n, pull in (("a", 50, 45), ("a", 50, 450), ("a", 25, 45), ("b", 25, 450))
    ]
    head, _, *rows = everything.table(points, "at once").splitlines()
    assert head.startswith("| break at once, 45 / 450 kN | N |")
    assert rows == [
        "| a | 25 | 1 / - | 2 / - | 3 / - | 4 / - | +1.000 / - | 2 / - | 7 / - |",
        "| a | 50 | 1 / 1 | 2 / 2 | 3 / 3 | 4 / 4 | +1.000 / +1.000 | 2 / 2 | 7 / 7 |",
        "| b | 25 | - / 1 | - / 2 | - / 3 | - / 4 | - / +1.000 | - / 2 | - / 7 |",
    ]
    peers = [
        one("45 kN, at once", 50, program="MoorDyn", setting="RK2, 0.4, 0"),
        one("45 kN, at once", 50, program="MoorDyn", setting="RK4, 0.8, 0"),
        one("45 kN, at once", 50, program="lumpedcable", setting=DEFAULT),
        one(compare.LINEAR, 50, program="SciPy", setting="RK45, 1e-3"),
    ]
    rows = everything.others(peers, "at once").splitlines()[2:]
    assert [row.split(" | ")[0] for row in rows] == [
        "| MoorDyn, RK2, 0.4, 0",
        "| MoorDyn, RK4, 0.8, 0",
    ]


def test_the_page_takes_the_tables_that_there_are():
    page = "<!-- benchmark one -->\nold\n<!-- end -->\n<!-- benchmark two -->\nkept\n<!-- end -->\n"
    made = report.filled(page, {"one": "| new |"})
    assert "| new |" in made
    assert "old" not in made
    assert "kept" in made


def test_a_target_is_met_or_not():
    good = {"displacement": 0.0, "velocity": 9e-3, "tension": 2e-3, "tension_fine": 1e-2,
            "front": -5e-5}  # fmt: skip
    names = [c.name for c in MAIN if c.name.endswith("5 ms")]
    points = [
        {
            "method": DEFAULT,
            "case": name,
            "segments": 100,
            "errors": good,
            "warm": 1.0,
            "status": "OK",
        }
        for name in names
    ]
    met = [row for row in targets.table(points, []).splitlines() if "kN |" in row]
    assert len(met) == 10
    assert all(row.endswith("| met |") for row in met)
    bad = [p | {"errors": {k: 10 * v for k, v in good.items()}} for p in points]
    rows = [row for row in targets.table(bad, []).splitlines() if "kN |" in row]
    assert all(row.endswith("| not met |") for row in rows)


def test_against_moordyn_the_default_is_timed_at_its_best_error():
    case = "45 kN, at once"
    mine = [
        {
            "method": DEFAULT,
            "case": case,
            "segments": n,
            "warm": t,
            "errors": {"velocity": e},
            "status": "OK",
        }
        for n, t, e in ((25, 1.0, 1e-1), (50, 10.0, 1e-2))
    ]
    peer = [
        {"program": "MoorDyn", "setting": s, "case": case, "segments": 50, "warm": t,
         "errors": {"velocity": e}}
        for s, t, e in (("a", 50.0, 5e-2), ("b", 99.0, math.nan))
    ]  # fmt: skip
    found = headline.against_moordyn(mine, peer, "velocity")[case]
    assert found["error"] == 5e-2
    # 0.1 at 1 s and 0.01 at 10 s: 0.05 at 2 s
    assert float(found["ratio"]) == pytest.approx(25.0, rel=1e-3)


def test_the_chain_for_scipy_is_the_same_line():
    # two programs, one problem: they agree to what the time steps leave
    line = line_of(scene_of(*CASE.changes))
    other = scipy_line.solve(line, 8, ("DOP853", 1e-6), 0.03)
    scene = scene_of(
        *CASE.changes, *METHOD[RK4].changes, "segments=8", "output.duration=30 ms", "solver.step=0.2 ms",
    )  # fmt: skip
    runner = Runner(scene)
    mine, status = runner.histories(runner.every, runner.steps, runner.count)
    assert (other.status, status) == ("OK", Status.OK)
    np.testing.assert_allclose(other.histories.velocity, mine.velocity, rtol=1e-3, atol=1e-2)
    assert other.histories.displacement == pytest.approx(mine.displacement, rel=1e-4)


def test_moordyns_table_follows_the_law():
    line = line_of(scene_of("pretension=450 kN"))
    strain, tension = moordyn_line.law_table(line)
    assert strain.size <= moordyn_line.POINTS
    assert np.all(np.diff(strain) > 0.0)
    e = np.linspace(0.0, line.strain(line.pull), 1001)
    straight = np.interp(e, strain, tension)
    # pieces of a curve with T'' up to 22 MN over at most 0.3 / 27: (h^2 / 8) T'' = 340 N
    assert np.max(np.abs(straight - line.tension(e))) < 400.0
    assert np.interp(line.strain(line.pull), strain, tension) == pytest.approx(450e3, rel=1e-12)


def test_the_linear_line_is_exact_in_its_own_way():
    line = line_of(scene_of(*compare.HOOKE, "pretension=50 kN"))
    truth = compare.exact_linear(line, 0.09)
    # 50 kN over 1 MN at 1000 m/s: 50 m/s, for 90 ms
    np.testing.assert_allclose(truth.velocity[1:], -50.0, rtol=1e-12)
    assert truth.displacement == pytest.approx(-4.5, rel=1e-12)
    assert errors(truth, truth).velocity == 0.0


def test_moordyn_runs_the_line():
    pytest.importorskip("moordyn")
    case = next(c for c in MAIN if c.name == "45 kN, at once")
    found = moordyn_line.solve(line_of(scene_of(*case.changes)), 25, ("RK2", 0.4, 0.2), 0.05)
    # ripples of a few per cent on 43 m/s less drag, which takes 8 m/s of it in 50 ms
    speed = -found.histories.velocity[10:]
    assert found.status == "OK"
    assert 28.0 < speed.min() < speed.max() < 48.0
    assert found.histories.tension[:40] == pytest.approx(45e3, rel=0.02)


@pytest.mark.slow
def test_pyelastica_runs_a_linear_line():
    pytest.importorskip("elastica")
    line = line_of(scene_of(*compare.HOOKE, "pretension=500"))
    found = elastica_line.solve(line, 50, 0.5, 0.05).histories
    # 0.05 % of strain: 0.5 m/s in the mean over the ripples that it leaves
    assert found.velocity[20:].mean() == pytest.approx(-0.5, rel=0.01)
