"""Input files of MoorDyn as scenes: the numbers that they hold, and a mooring against own equations."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from adopted import scene_of, tells
from command_line import say
from scipy.integrate import solve_ivp
from scipy.optimize import root

from lumpedcable.adopt.moordyn import read_moordyn
from lumpedcable.adopt.mooring import mooring_scene
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

SPREAD = Path(__file__).parents[2] / "configs" / "peers" / "spread-mooring.txt"
LATE = """\
--- a line of two parts, and a buoy
--- LINE TYPES
Name  Diam   Mass  EA     BA/-zeta  EI   Cd   Ca   CdAx  CaAx
(-)   (m)    (kg/m) (N)   (N-s/-)  (N-m2) (-) (-)  (-)   (-)
rope  0.05   2.2   1.0D6  -0.1     0     1.2  1.0  0.02  0.3
wire  0.02   1.5   4.0e7  300      50    1.1  0.0  0.0   0.0
--- POINTS
ID  Type     X    Y    Z    Mass  Volume CdA Ca
(#) (-)      (m)  (m)  (m)  (kg)  (m3) (m2) (-)
1   Fixed    0    0    -50  0     0    0    0     ! the anchor
2   free     20   0    -30  0     0    0    0
3   Connect  40   0    -10  80    0.2  0.4  0.5
4   Coupled  60   0    -5   0     0    0    0
--- LINES
ID  Type  A  B  UnstrLen NumSegs Outputs
(#) (-)   (#) (#) (m)    (-)     (-)
1   rope  1  2  30       6       -
2   rope  2  3  30       12      -
3   wire  3  4  25       5       p
--- OPTIONS
0.001     dtM
rk4       tScheme
1020      WtrDnsty
9.8       g
50        WtrDpth
2e6       kBot
1e5       cBot
0.4       FrictionCoefficient
--- need this line
"""
EARLY = """\
---- MoorDyn v1
---- LINE DICTIONARY
LineType Diam MassDen EA BA/-zeta Can Cat Cdn Cdt
(-) (m) (kg/m) (N) (Pa-s/-) (-) (-) (-) (-)
rope 0.05 2.2 1.0e6 -0.1 1.0 0.3 1.2 0.02
wire 0.02 1.5 4.0e7 300 0 0 1.1 0
---- NODE PROPERTIES
Node Type X Y Z M V FX FY FZ CdA CA
(-) (-) (m) (m) (m) (kg) (m^3) (kN) (kN) (kN) (m^2) (-)
1 Fix 0 0 -50 0 0 0 0 0 0 0
2 Connect 20 0 -30 0 0 0 0 0 0 0
3 Connect 40 0 -10 80 0.2 0 0 0 0.4 0.5
4 Vessel 60 0 -5 0 0 0 0 0 0 0
---- LINE PROPERTIES
Line LineType UnstrLen NumSegs NodeAnch NodeFair Flags/Outputs
(-) (-) (m) (-) (-) (-) (-)
1 rope 30 6 1 2 p
2 rope 30 12 2 3 p
3 wire 25 5 3 4 p
---- SOLVER OPTIONS
1020 rhoW
9.8 g
50 WtrDpth
2e6 kb
1e5 cb
0.4 FrictionCoefficient
---- need this line
"""


def test_every_number_is_where_a_scene_has_it(tmp_path):
    scene, remarks = scene_of(tmp_path, LATE)
    assert (scene["gravity"], scene["water"]) == (9.8, {"density": 1020.0, "surface": 0.0})
    assert scene["seabed"] == pytest.approx(
        {"height": -50.0, "stiffness": 2e6 * 0.05, "damping": 1e5 * 0.05, "friction": 0.4}
    )
    # a tenth of the critical damping sqrt(EA m) l of segments of 5 and of 2.5 m
    critical = np.sqrt(1e6 * 2.2)
    assert [m.pop("damping") for m in scene["materials"].values()] == pytest.approx(
        [0.1 * 5.0 * critical, 0.1 * 2.5 * critical, 300.0]
    )
    assert scene["materials"] == {
        "rope": {"law": "linear", "EA": 1e6, "tension_only": True},
        "rope_2": {"law": "linear", "EA": 1e6, "tension_only": True},
        "wire": {"law": "linear", "EA": 4e7, "tension_only": True},
    }
    # what MoorDyn is told the motion of rests until the scene is told it
    rest = {"surge": {"amplitude": 0.0, "period": 10.0}}
    assert scene["bodies"] == {
        "vessel": {"position": [0, 0, 0], "motion": rest, "points": {"point4": [60, 0, -5]}},
        "point3": {"mass": 80.0, "volume": 0.2, "position": [40, 0, -10]},
    }
    first, second, third = (scene["lines"][f"line{k}"] for k in (1, 2, 3))
    rope = {"length": 30.0, "mass": 2.2, "diameter": 0.05,
            "drag": {"normal": 1.2, "tangential": 0.02},
            "added_mass": {"normal": 1.0, "tangential": 0.3}}  # fmt: skip
    assert first == rope | {"material": "rope", "segments": 6, "start": {"fixed": [0, 0, -50]},
                            "end": "line2.start"}  # fmt: skip
    assert second == rope | {"material": "rope_2", "segments": 12, "start": "line1.end",
                             "end": "point3"}  # fmt: skip
    assert third == {
        "material": "wire", "length": 25.0, "segments": 5, "mass": 1.5, "diameter": 0.02,
        "drag": {"normal": 1.1, "tangential": 0.0}, "bending": {"EI": 50.0},
        "start": "point3", "end": "vessel.point4",
    }  # fmt: skip
    assert "duration" not in scene["output"]
    assert remarks == [
        "not taken over: CdA and Ca of point 3; a rigid body has drag and added mass",
        "the bed is as stiff as under a line of 0.05 m diameter, also under others",
    ]


def test_the_early_layout_is_the_same_mooring(tmp_path):
    late, remarks = scene_of(tmp_path, LATE.replace("300      50 ", "300      0  "))
    assert scene_of(tmp_path, EARLY) == (late, remarks)


def test_a_point_that_holds_nothing_is_a_free_end(tmp_path):
    text = LATE.replace(
        "3   Connect  40   0    -10  80    0.2 ", "3   Connect  40   0    -10  0 0 "
    )
    text = text.replace("3   wire  3  4  25       5       p\n", "")
    scene, _ = scene_of(tmp_path, text)
    assert "bodies" not in scene
    assert scene["lines"]["line2"]["end"] == "free"


def test_what_three_lines_meet_at_weighs_a_gram_and_is_told(tmp_path):
    text = LATE.replace("Connect  40   0    -10  80    0.2  0.4  0.5", "Free 40 0 -10 0 0 0 0")
    text = text.replace("--- OPTIONS", "4 wire 4 3 26 5 -\n--- OPTIONS")
    scene, remarks = scene_of(tmp_path, text)
    assert scene["bodies"]["point3"] == {"mass": 1e-3, "position": [40.0, 0.0, -10.0]}
    assert remarks[-1] == "point 3 has a mass of 1 g, since bodies have one"


def test_coefficients_under_other_names_are_told(tmp_path):
    text = LATE.replace("EI   Cd   Ca   CdAx  CaAx", "EI   Can  Cat  Cdn   Cdt")
    scene, remarks = scene_of(tmp_path, text)
    assert scene["lines"]["line1"]["drag"] == {"normal": 1.2, "tangential": 0.02}
    assert remarks[0] == (
        "coefficients are taken as Cd, Ca, CdAx, CaAx, as MoorDyn takes them, which the file calls "
        "Can, Cat, Cdn, Cdt"
    )


def test_what_has_no_counterpart_is_told(tmp_path):
    text = LATE.replace("--- POINTS", "--- CONTROL\na b\n() (,)\n1 1,2\n--- POINTS")
    text = text.replace("-0.1     0 ", "-0.1     0|3 ").replace(
        "0.001     dtM", "1  WaveKin\nx.txt WaterKin\ny.txt SeafloorFile"
    )
    _, remarks = scene_of(tmp_path, text)
    told = [remark for remark in remarks if "not taken over" in remark]
    assert told[:5] == [
        "not taken over: the dynamic part of EI of rope, 0|3 (line 5)",
        "not taken over: WaveKin = 1 (line 25): give a scene its waves",
        "not taken over: WaterKin = x.txt (line 26): give a scene its current and waves",
        "not taken over: SeafloorFile = y.txt (line 27): give the bed a profile",
        "not taken over: 1 row of control",
    ]


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("3   wire  3  4 ", "3   wire  3  R1A ", 19, "line 3: expected the number of a point, found 'R"),
        ("3   wire  3 ", "3   wyre  3 ", 19, "line 3: expected a line type (rope, wire), found 'wyre'"),
        ("1   Fixed ", "1   Body1 ", 10, "fixed, coupled, free or on a body, found 'Body1'"),
        ("4.0e7 ", "stress.txt ", 6, "EA of wire: expected a number, found 'stress.txt'"),
        ("2   rope  2  3  30       12      -", "2   rope  2  3  30", 18, "at least 6 columns, found 5"),
        ("30       6  ", "30       0  ", 17, "line 1: expected a whole number from 1 on, found '0'"),
        ("30       6  ", "30       6.5", 17, "expected a whole number from 1 on, found '6.5'"),
        ("30       6  ", "-3       6  ", 17, "line 1: expected a positive number, found '-3'"),
        ("1.1  0.0  0.0   0.0", "1.1  0.0  0.0", 6, "types: expected at least 10 columns, found 9"),
        ("1.1  0.0  0.0   0.0", "1.1  nan  0.0   0.0", 6, "Ca of wire: expected a number, found 'nan'"),
        ("300      50 ", "300      -5 ", 6, "EI of wire: expected a number from 0 on, found '-5'"),
        ("80    0.2 ", "80    -.2 ", 12, "point 3: expected a number from 0 on, found '-.2'"),
        ("3   Connect", "2   Connect", 12, "2: expected a name of its own, found '2' again"),
        ("3   wire  3  4", "2   wire  3  4", 19, "2: expected a name of its own, found '2' again"),
        ("3   wire  3  4", "3.5 wire  3  4", 19, "expected letters, digits, _ and -, found '3.5'"),
        ("3   wire  3  4", "3   wire  3  3", 19, "line 3: expected two points, found 3 twice"),
        ("(#) (-)   (#) (#) (m)    (-)     (-)", "0 rope 1 3 20 4 -", 16, "expected a row of units"),
        ("9.8       g", "g         9.8", 24, "g: expected a value before its name, found 9.8 behind it"),
        ("2e6       kBot", "0         kBot", 26, "kBot: expected a positive number, found '0'"),
        ("1.0D6", "0    ", 5, "EA of rope: expected a positive number, found '0'"),
        ("50        WtrDpth", "bed.txt   WtrDpth", 25, "WtrDpth: expected a depth (m), found 'bed.txt'"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_line(tmp_path, old, new, line, words):
    assert old in LATE
    tells(tmp_path, LATE.replace(old, new), line, words)


def test_a_section_may_go_on_further_down(tmp_path):
    more = (
        "--- LINES\nID  Type  A  B  L N O\n(#) (-) (#) (#) (m) (-) (-)\n4 wire 1 4 90 9 -\n--- need"
    )
    scene, _ = scene_of(tmp_path, LATE.replace("--- need", more))
    assert list(scene["lines"]) == ["line1", "line2", "line3", "line4"]
    assert scene["lines"]["line4"]["length"] == 90.0


def test_points_may_be_named_with_their_kind_and_a_file_have_a_mark_of_its_coding(tmp_path):
    plain, _ = scene_of(tmp_path, LATE)
    named = LATE.replace("rope  1  2 ", "rope P1 Point2 ").replace("--- a line", "\ufeff--- a line")
    assert scene_of(tmp_path, named)[0] == plain


def test_what_is_over_the_surface_is_dry_and_a_bed_that_is_not_there_is_told(tmp_path):
    text = LATE.replace("60   0    -5 ", "60   0    5  ").replace(
        "50        WtrDpth\n", "0.0 WaveKin\n"
    )
    scene, remarks = scene_of(tmp_path, text)
    assert "seabed" not in scene
    assert remarks[1:] == ["there is no bed, since the file has no WtrDpth above 0"]
    assert scene["water"]["surface"] == 0.0


def test_what_floats_has_a_surface_to_float_at_and_what_stays_under_water_none(tmp_path):
    assert scene_of(tmp_path, LATE)[0]["water"]["surface"] == 0.0
    sunk = LATE.replace("80    0.2 ", "80    0.0 ")
    assert "surface" not in scene_of(tmp_path, sunk)[0]["water"]


def test_rows_tell_of_the_layout_whatever_the_names_over_them(tmp_path):
    plain, _ = scene_of(tmp_path, LATE)
    assert scene_of(tmp_path, LATE.replace("CdAx  CaAx", "CdAx"))[0] == plain
    remarked = LATE.replace("Volume CdA Ca", "Volume CdA Ca and so on further below")
    assert scene_of(tmp_path, remarked)[0] == plain
    # a row that lacks a column is of neither layout
    for text, old, new in (
        (LATE, "1.2  1.0  0.02  0.3", "1.2  1.0  0.02"),
        (EARLY, "1 Fix 0 0 -50 0 0 0 0 0 0 0", "1 Fix 0 0 -50 0 0 0 0 0 0"),
    ):
        (tmp_path / "mooring.txt").write_text(text.replace(old, new))
        with pytest.raises(SceneError, match=r"expected at least 1[02] columns"):
            read_moordyn(tmp_path / "mooring.txt")


def test_tables_that_say_how_many_rows_they_have_are_the_same(tmp_path):
    plain, _ = scene_of(tmp_path, EARLY)
    counted = EARLY
    for head, count in (
        ("LineType D", "2 NTypes"),
        ("Node T", "4 NConnects"),
        ("Line L", "3 NLines"),
    ):
        counted = counted.replace(f"\n{head}", f"\n{count} - how many there are\n{head}", 1)
    assert counted.count(" - how many there are") == 3
    assert scene_of(tmp_path, counted)[0] == plain


def test_options_that_are_not_understood_are_told(tmp_path):
    more = LATE.replace("9.8       g\n", "9.8       g\n9.7  grav\n2  WriteLog\n")
    _, remarks = scene_of(tmp_path, more)
    assert [r for r in remarks if "option" in r] == ["not taken over: option grav = 9.7 (line 25)"]
    (tmp_path / "mooring.txt").write_text(LATE.replace("9.8       g", "9,8       g"))
    with pytest.raises(SceneError, match="g: expected a number, found '9,8'"):
        read_moordyn(tmp_path / "mooring.txt")


def test_a_weight_that_no_line_holds_is_told(tmp_path):
    loose = LATE.replace("4   Coupled", "5 free 1 2 -3 500 0.9 0 0\n4   Coupled")
    scene, remarks = scene_of(tmp_path, loose)
    assert "not taken over: point 5, which no line holds" in remarks
    assert "point5" not in scene["bodies"]


@pytest.mark.slow
def test_a_slack_line_hangs_slack(tmp_path):
    # a line of MoorDyn does not push: of 110 m between points 75 m apart some lie on the bed
    text = LATE[: LATE.index("--- POINTS")] + "--- POINTS\nID T X Y Z M V CdA Ca\n(#) (-)\n"
    text += (
        "1 Fixed 0 0 -50 0 0 0 0\n2 Coupled 60 0 -5 0 0 0 0\n--- LINES\nID T A B Len N O\n(#) (-)\n"
    )
    text += "1 rope 1 2 110 22 -\n--- OPTIONS\n50 WtrDpth\n--- need this line\n"
    scene_of(tmp_path, text)
    (outcome,) = run_study(load_study(tmp_path / "mooring.toml"), tmp_path / "slack.h5")
    assert outcome.status.name == "OK"
    with open_result(tmp_path / "slack.h5") as result:
        tension = result.line("line1").tension(0)[0]
        z = result.line("line1").position(0)[0, :, 2]
    assert tension.min() > -1.0
    assert z.min() > -50.5


@pytest.mark.parametrize("text", ["", "title = 1\n", "\x00\xff\x89HDF", "--- LINES\n"])
def test_what_is_no_such_file_is_told(tmp_path, text):
    (tmp_path / "mooring.txt").write_text(text, encoding="latin-1")
    with pytest.raises(SceneError, match="expected a table of types, found none"):
        read_moordyn(tmp_path / "mooring.txt")
    with pytest.raises(SceneError, match="cannot be read"):
        read_moordyn(tmp_path)


def test_the_command_writes_a_scene_once(tmp_path):
    said = say(tmp_path, "import", str(SPREAD))
    assert (said.code, said.out) == (0, "spread-mooring.toml\n")
    assert "the bed is as stiff as under a line of 0.137 m diameter" in said.err
    before = (tmp_path / "spread-mooring.toml").read_text()
    said = say(tmp_path, "import", str(SPREAD))
    assert (said.code, said.out) == (2, "")
    assert "it is there already" in said.err
    assert (tmp_path / "spread-mooring.toml").read_text() == before
    said = say(tmp_path, "import", "none.txt", "-o", "other.toml")
    assert (said.code, said.err) == (2, "none.txt: cannot be read: No such file or directory\n")
    assert not (tmp_path / "other.toml").exists()


def test_it_loads_no_jax():
    told = "import sys, lumpedcable.adopt.mooring; print('jax' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert found.stdout == "False\n"


def leg():
    """Where the joint of a leg is (m), and the tension (N) at the float, if its bed were hard.

    From the anchor on, H and the vertical force V(s) along the unstretched s: the chain lies as far as
    V would be negative, a clump adds its weight, the polyester goes on.
    """
    g, rho = 9.80665, 1025.0

    def weight(mass, diameter):
        return (mass - rho * np.pi / 4 * diameter**2) * g

    chain, rope, clump = weight(115.0, 0.137), weight(17.5, 0.14), (4000.0 - rho * 0.6) * g

    def hung(H, V, w, EA, length):
        def slopes(s, _):
            pull = np.hypot(H, V + w * s)
            return np.array([H, V + w * s]) * (1.0 / pull + 1.0 / EA)

        found = solve_ivp(slopes, (0.0, length), [0.0, 0.0], rtol=1e-10, atol=1e-10)
        return found.y[:, -1], V + w * length

    def parts(unknown):
        H, lying = unknown
        first, V = hung(H, 0.0, chain, 4.9e8, 380.0 - lying)
        second, top = hung(H, V + clump, rope, 8e7, 130.0)
        return lying * (1.0 + H / 4.9e8), first, second, np.hypot(H, top)

    def misses(unknown):
        lying, first, second, _ = parts(unknown)
        return [lying + first[0] + second[0] - 480.0, first[1] + second[1] - 102.0]

    found = root(misses, [150e3, 300.0], tol=1e-10)
    assert found.success
    lying, first, _, tension = parts(found.x)
    return 500.0 - lying - first[0], -120.0 + first[1], tension


@pytest.mark.slow
def test_a_spread_mooring_hangs_as_its_legs_do(tmp_path):
    text, _ = mooring_scene(read_moordyn(SPREAD), "spread")
    (tmp_path / "spread.toml").write_text(text)
    run_study(load_study(tmp_path / "spread.toml"), tmp_path / "spread.h5")
    x, z, tension = leg()
    with open_result(tmp_path / "spread.h5") as result:
        joint = result.line("line1").position(0)[0, -1]
        pull = result.line("line4").field("end_tension")[0, 0]
        turned = result.line("line2").position(0)[0, -1]
    # the bed gives by 8 cm under the chain, which hangs from the joint
    assert joint == pytest.approx([x, 0.0, z], abs=0.02)
    assert pull == pytest.approx(tension, rel=2e-3)
    assert np.hypot(*turned[:2]) == pytest.approx(joint[0], abs=0.05)
