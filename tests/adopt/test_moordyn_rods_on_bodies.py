"""A float that is made of a body and of rods on it: one body, as MoorDyn counts it."""

import numpy as np
import pytest
from adopted import moordyn_at_rest, scene_of, tells

from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

FLOAT = """\
--- a float of a ball, a can and a bar, on three legs
--- LINE TYPES
Name  Diam  Mass EA BA EI Cd Ca CdAx CaAx Cl dF cF
(-) (m) (kg/m) (N) (N-s/-) (N-m2) (-) (-) (-) (-) (-) (-) (-)
rope 0.05 2.5 1e6 -0.5 0 1.2 1.0 0.02 0.3 0 0 0
--- ROD TYPES
Name Diam Mass Cd Ca CdEnd CaEnd
(-) (m) (kg/m) (-) (-) (-) (-)
can 1.0 100 1.2 1.0 0.6 0.5
bar 0.2 40 1.2 0.5 0.6 0.5
--- BODIES
ID  Attachment  X0   Y0   Z0   r0   p0  y0   Mass  CG  I     Volume  CdA  Ca
(#) (word)      (m)  (m)  (m) (deg) (deg) (deg) (kg) (m) (kg-m^2) (m^3) (m^2) (-)
1   Free        0 0  -13  0    0   0   2000  0  1500  3  0    0.6
--- RODS
ID Type Attachment Xa Ya Za Xb Yb Zb NumSegs Outputs
(#) (-) (-) (m) (m) (m) (m) (m) (m) (-) (-)
1 can Body1 0 0 -2 0 0 2 4 -
--- POINTS
ID  Type     X      Y     Z    Mass  Volume CdA Ca
(#) (-)      (m)    (m)   (m)  (kg)  (m3) (m2) (-)
1   Fixed    40    0     -50  0     0    0    0
2   Fixed    -20    34    -50  0     0    0    0
3   Fixed    -20    -34   -50  0     0    0    0
4   Body1    1    0     -1   0     0    0    0
5   Body1    -0.5  0.866   -1   0     0    0    0
6   Body1    -0.5  -0.866  -1   0     0    0    0
--- LINES
ID  Type  A  B  UnstrLen NumSegs Outputs
(#) (-)   (#) (#) (m)    (-)     (-)
1   rope  1  4  53       20      -
2   rope  2  5  53       20      -
3   rope  3  6  53       20      -
--- OPTIONS
50 WtrDpth
1 ICgenDynamic
0.0005 dtM
600 TmaxIC
1e-7 threshIC
0 writeLog
--- need this line
"""
BAR = "1 can Body1 0 0 -2 0 0 2 4 -\n2 bar Body1 0.4 1 0.5 3.4 5 0.5 4 -"


def test_a_rod_is_part_of_its_body(tmp_path):
    scene, remarks = scene_of(tmp_path, FLOAT)
    body, volume = scene["bodies"]["body1"], np.pi
    assert body["mass"] == pytest.approx(2400)
    assert body["volume"] == pytest.approx(3 + volume)
    # a cylinder of 400 kg, 1 m wide and 4 m long, about its middle
    across, along = 400 * (0.25 * 0.25 + 16 / 12), 400 * 0.25 / 2
    assert body["inertia"] == pytest.approx([1500 + across, 1500 + across, 1500 + along])
    assert body["added_mass"] == pytest.approx(
        np.array([1.8 + volume, 1.8 + volume, 1.8]) / (3 + volume)
    )
    assert remarks[0].startswith("mass, volume and Ca of rod 1 are in those of body 1; water lifts")


def test_rods_that_are_off_the_middle_move_the_centre_of_gravity(tmp_path):
    scene, _ = scene_of(tmp_path, FLOAT.replace(BAR.splitlines()[0], BAR))
    body, bar = scene["bodies"]["body1"], np.array([1.9, 3, 0.5])
    centre = 200 * bar / 2600  # 5 m of 40 kg/m
    assert body["mass"] == pytest.approx(2600)
    assert body["position"] == pytest.approx(np.array([0, 0, -13]) + centre)
    assert body["points"]["point4"] == pytest.approx(np.array([1, 0, -1]) - centre)
    # as the sum over many masses along each rod, all of them about the common centre
    s = (np.arange(2000) + 0.5) / 2000 - 0.5
    pieces = np.concatenate([np.outer(s, [0, 0, 4]), bar + np.outer(s, [3, 4, 0])])
    masses = np.repeat([400 / 2000, 200 / 2000], 2000)
    away = pieces - centre
    moments = masses @ (np.sum(away**2, axis=1)[:, None] - away**2)
    own = 2000 * (centre @ centre - centre**2) + 1500
    disc = np.array([400, 400, 2 * 400]) * 0.25 / 4  # of the width of the can
    u = np.array([0.6, 0.8, 0])
    disc += 200 * 0.01 / 4 * (1 + u**2)
    assert body["inertia"] == pytest.approx(moments + own + disc, rel=1e-5)


def test_a_body_may_be_made_of_rods_alone(tmp_path):
    bare = FLOAT.replace("2000  0  1500  3", "0  0  0  0")
    body = scene_of(tmp_path, bare)[0]["bodies"]["body1"]
    assert (body["mass"], body["volume"]) == pytest.approx((400, np.pi))
    tells(tmp_path, bare.replace("1 can Body1", "1 can Fixed"), 14, "with mass and moments of")


def test_a_rod_of_no_type_is_told(tmp_path):
    wrong = FLOAT.replace("1 can Body1", "1 pipe Body1")
    tells(tmp_path, wrong, 18, "rod 1: expected a rod type (can, bar), found 'pipe'")


def test_what_vortices_do_is_told(tmp_path):
    told = "what vortices do to lines of type rope, 0.8 0.18 0.05 (line 5)"
    assert not [r for r in scene_of(tmp_path, FLOAT)[1] if "vortices" in r]
    shaken = FLOAT.replace("0.3 0 0 0", "0.3 0.8 0.18 0.05")
    assert f"not taken over: {told}" in scene_of(tmp_path, shaken)[1]


def test_a_depth_below_0_is_one(tmp_path):
    assert scene_of(tmp_path, FLOAT.replace("50 WtrDpth", "-50 WtrDpth")) == scene_of(
        tmp_path, FLOAT
    )


@pytest.mark.slow
def test_the_float_pulls_as_moordyn_has_it(tmp_path):
    scene_of(tmp_path, FLOAT)
    (outcome,) = run_study(load_study(tmp_path / "mooring.toml"), tmp_path / "rest.h5")
    assert outcome.status.name == "OK"
    with moordyn_at_rest(tmp_path) as (moordyn, system):
        place = moordyn.GetBodyState(moordyn.GetBody(system, 1))[0]
        pulls = [moordyn.GetLineFairTen(moordyn.GetLine(system, k)) for k in (1, 2, 3)]
    with open_result(tmp_path / "rest.h5") as result:
        own = result.body("body1", "position")[0, 0]
        found = [result.line(f"line{k}").tension(0)[0, -1] for k in (1, 2, 3)]
    assert min(pulls) > 15e3  # without the rod the legs pull with 5 kN
    assert own == pytest.approx(place[:3], abs=2e-3)
    assert found == pytest.approx(pulls, rel=2e-3)


STIFF = (
    FLOAT.replace("0.05 2.5 1e6 -0.5 0 1.2", "0.05 2.5 1e6 -0.5 5e5 1.2")
    .replace("1   rope  1  4  53       20", "1   rope  1  R1A  53       40")
    .replace("-13  0    0   0   2000", "-13  0    0   30   2000")
)


def test_a_leg_that_bends_is_clamped_to_the_rod_that_it_ends_at(tmp_path):
    """It ends at the rod's end A, whose axis goes up to B: in the axes of the body, however turned."""
    scene, remarks = scene_of(tmp_path, STIFF)
    end = scene["lines"]["line1"]["end"]
    assert end == {"tied": "body1.pointR1A", "direction": [0, 0, 4]}
    assert not [remark for remark in remarks if "clamp" in remark]
    moved = STIFF.replace("1   Free        0 0", "1   Coupled     0 0")
    moved = moved.replace("1 can Body1 0 0 -2 0 0 2", "1 can Body1 -1 0 -2 1 0 -2")
    scene, _ = scene_of(tmp_path, moved)
    end = scene["lines"]["line1"]["end"]
    assert end["direction"] == pytest.approx([2 * np.cos(np.pi / 6), 2 * np.sin(np.pi / 6), 0])
