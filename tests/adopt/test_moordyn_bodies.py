"""Bodies and failures of MoorDyn's files as scenes, and a buoy on three legs beside MoorDyn itself."""

import numpy as np
import pytest
from adopted import moordyn_at_rest, scene_of, tells
from scipy.spatial.transform import Rotation

from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

BUOY = """\
--- a buoy under water on three legs, two slack wires to a ship
--- LINE TYPES
Name  Diam   Mass   EA     BA/-zeta  EI   Cd   Ca   CdAx  CaAx
(-)   (m)    (kg/m) (N)    (N-s/-)  (N-m2) (-) (-)  (-)   (-)
rope  0.05   2.5    1.0e6  -0.5      0    1.2  1.0  0.02  0.3
wire  0.02   1.5    4.0e6  -0.5      0    1.1  1.0  0.0   0.0
--- BODIES
ID  Attachment  X0   Y0   Z0   r0   p0  y0   Mass  CG            I               Volume  CdA  Ca
(#) (word)      (m)  (m)  (m) (deg) (deg) (deg) (kg) (m)         (kg-m^2)        (m^3)   (m^2) (-)
1   Free        0.5  0.2  -13  0    5   10   2000  0.3|0.1|-0.5  1500|1800|1200  4       2    0.6
2   Fixed       40   0    -50  20   30  40   0     0             0               0       0    0
3   Coupled     8    4    -5   0    0   90   0     0             0               0       0    0
--- POINTS
ID  Type     X      Y     Z    Mass  Volume CdA Ca
(#) (-)      (m)    (m)   (m)  (kg)  (m3) (m2) (-)
1   Body2    1      2     3    0     0    0    0
2   Fixed    -20    34    -50  0     0    0    0
3   Fixed    -20    -34   -50  0     0    0    0
4   Body1    1.5    0     -1   0     0    0    0
5   BODY1    -0.75  1.3   -1   0     0    0    0
6   body1    -0.75  -1.3  -1   7     0    0    0
7   Coupled  10     0     -5   0     0    0    0
8   Body3    1      2     0    0     0    0    0
9   Body1    0      0     1    0     0    0    0
--- LINES
ID  Type  A  B  UnstrLen NumSegs Outputs
(#) (-)   (#) (#) (m)    (-)     (-)
1   rope  1  4  53       20      -
2   rope  2  5  53       20      -
3   rope  3  6  53       20      -
4   wire  7  9  15       10      -
5   wire  8  9  15       10      -
--- FAILURE
FailureID Point Line(s) FailTime FailTen
() () (,) (s) (N)
1   P1    1     12     0
2   7     4     3      60e3
3   9     4,5   1      0
--- OPTIONS
50        WtrDpth
--- need this line
"""


def moment_of(mass, away):
    """Moments of inertia (kg m2) about x, y and z of a mass (kg) that is `away` (m)."""
    return mass * (away @ away - away**2)


def test_bodies_are_where_they_are_and_turned_as_they_are(tmp_path):
    scene, remarks = scene_of(tmp_path, BUOY)
    # MoorDyn turns about a body's own x, then y, then z; a scene about x, y and z at rest
    turn = Rotation.from_euler("XYZ", [0, 5, 10], degrees=True)
    # with the 7 kg of point 6 on it
    own, on = np.array([0.3, 0.1, -0.5]), np.array([-0.75, -1.3, -1])
    body, centre = scene["bodies"]["body1"], (2000 * own + 7 * on) / 2007
    assert (body["mass"], body["volume"]) == (2007, 4)
    about = [moment_of(2000, own - centre), moment_of(7, on - centre)]
    assert body["inertia"] == pytest.approx(np.array([1500, 1800, 1200]) + sum(about))
    assert (body["added_mass"], body["settle"]) == ([0.6, 0.6, 0.6], True)
    own = Rotation.from_euler("xyz", body["attitude"])
    assert own.as_matrix() == pytest.approx(turn.as_matrix(), abs=1e-12)
    assert body["position"] == pytest.approx(np.array([0.5, 0.2, -13]) + turn.apply(centre))
    assert body["points"]["point4"] == pytest.approx(np.array([1.5, 0, -1]) - centre)
    assert list(body["points"]) == ["point4", "point5", "point6", "point9"]
    # a fixed body's points are places, and those of a coupled one are on a body that is moved
    fixed = Rotation.from_euler("XYZ", [20, 30, 40], degrees=True).apply([1, 2, 3])
    assert scene["lines"]["line1"]["start"]["fixed"] == pytest.approx(
        fixed + np.array([40, 0, -50])
    )
    assert scene["bodies"]["body3"]["position"] == [8, 4, -5]
    assert scene["bodies"]["body3"]["points"]["point8"] == pytest.approx([-2, 1, 0])
    ends = [scene["lines"][f"line{k}"] for k in (1, 4, 5)]
    assert [end["end"] for end in ends] == ["body1.point4", "body1.point9", "body1.point9"]
    assert [end["start"] for end in ends[1:]] == ["vessel.point7", "body3.point8"]
    assert remarks[-5:] == [
        "mass and volume of point 6 are in those of body 1",
        "the bed is as stiff as under a line of 0.05 m diameter, also under others",
        "not taken over: CdA of body 1; give it a size, and drag on its faces",
        "failure 2 begins at its tension alone, not at 3 s",
        "not taken over: failure 3, after which lines stay tied to each other",
    ]


def test_failures_are_breaks_at_once(tmp_path):
    scene, _ = scene_of(tmp_path, BUOY)
    assert scene["events"] == {
        "failure1": {"breaks": "line1.start", "time": 0, "start": 12},
        "failure2": {"breaks": "line4.start", "time": 0, "tension": 60e3},
    }
    assert scene["output"] == {"duration": 72, "every": 0.1}


FAILS = """\
--- FAILURE
FailureID Point Line(s) FailTime FailTen
() () (,) (s) (N)
1 1 1 3 0
2 1 2 5 0
"""
RODS = """\
--- cables that stick out
--- LINE TYPES
Name  Diam   Mass  EA     BA/-zeta  EI   Cd   Ca   CdAx  CaAx
(-)   (m)    (kg/m) (N)   (N-s/-)  (N-m2) (-) (-)  (-)   (-)
cable 0.1    12    1.0e6  -0.8     2e4   1.2  1.0  0.02  0.3
rope  0.1    12    1.0e6  -0.8     0     1.2  1.0  0.02  0.3
--- ROD TYPES
Name Diam Mass Cd Ca CdEnd CaEnd
(-) (m) (kg/m) (-) (-) (-) (-)
can 0.2 50 0.6 1 1.2 1
--- RODS
ID RodType Attachment Xa Ya Za  Xb Yb Zb    NumSegs Out
(#) (-)    (-)        (m) (m) (m) (m) (m) (m) (-)   (-)
1  can     Fixed      0  0  -10 2  0  -10.5 2       -
2  can     Fixed      0  5  -10 2  5  -9.5  4       -
--- POINTS
ID  Type    X    Y   Z    Mass  Volume CdA Ca
(#) (-)     (m)  (m) (m)  (kg)  (m3)   (m2) (-)
1   Free    8    0   -9   0     0      0   0
2   Free    -8   5   -12  0     0      0   0
--- LINES
ID  Type   A   B   UnstrLen NumSegs Outputs
(#) (-)    (#) (#) (m)      (-)     (-)
1   cable  R1B 1   8        16      -
2   cable  2   R2A 8        16      -
--- OPTIONS
0.0005 dtM
50     WtrDpth
1      ICgenDynamic
100    TmaxIC
1e-8   threshIC
--- need this line
"""


def test_rods_hold_lines_and_those_that_bend_keep_their_direction(tmp_path):
    scene, remarks = scene_of(tmp_path, RODS)
    first, second = scene["lines"]["line1"], scene["lines"]["line2"]
    # from the start of a line towards its end: away from a rod's end B, towards its end A
    assert first["start"] == {"fixed": [2, 0, -10.5], "direction": [2, 0, -0.5]}
    assert second["end"] == {"fixed": [0, 5, -10], "direction": [2, 0, 0.5]}
    assert remarks == []
    # the other ends of the rods, a line that does not bend, a rod without segments, which has no length
    turned = RODS.replace("R1B 1", "rod1a 1").replace("2       -\n2  can", "0       -\n2  can")
    turned = turned.replace("2   cable  2   R2A", "2   rope  2   R2b")
    scene, _ = scene_of(tmp_path, turned)
    first, second = scene["lines"]["line1"], scene["lines"]["line2"]
    assert first["start"] == {"fixed": [0, 0, -10], "direction": [-2, 0, 0.5]}
    assert second["end"] == {"fixed": [2, 5, -9.5]}
    flat = turned.replace("rod1a", "R1B")
    assert scene_of(tmp_path, flat)[0]["lines"]["line1"]["start"]["fixed"] == [0, 0, -10]


def test_a_rod_that_moves_is_moved_or_told(tmp_path):
    scene, remarks = scene_of(tmp_path, RODS.replace("1  can     Fixed", "1  can     Coupled"))
    tied = {"tied": "vessel.pointR1B", "direction": [2, 0, -0.5]}
    assert scene["lines"]["line1"]["start"] == tied
    assert scene["bodies"]["vessel"]["points"] == {"pointR1B": [2, 0, -10.5]}
    assert remarks == []
    free = RODS.replace("2  can     Fixed", "2  can     Free ")
    with pytest.raises(
        SceneError, match=r"found .R2A. \(rods are taken that are fixed, coupled or on"
    ):
        scene_of(tmp_path, free)
    _, remarks = scene_of(tmp_path, free.replace("2   R2A", "2   1  "))
    assert "not taken over: rod 2, which is Free (line 15)" in remarks


@pytest.mark.slow
def test_cables_hang_from_rods_as_moordyn_has_them(tmp_path):
    scene_of(tmp_path, RODS)
    (outcome,) = run_study(load_study(tmp_path / "mooring.toml"), tmp_path / "rest.h5")
    assert outcome.status.name == "OK"
    with moordyn_at_rest(tmp_path) as (moordyn, system):
        lines = [moordyn.GetLine(system, k) for k in (1, 2)]
        told = [[moordyn.GetLineNodePos(line, j) for j in range(17)] for line in lines]
    with open_result(tmp_path / "rest.h5") as result:
        found = [result.line(f"line{k}").position(0)[0] for k in (1, 2)]
    # a meter of sag, and of slope beside it
    np.testing.assert_allclose(found, told, atol=1e-3)


def test_of_two_failures_at_one_place_the_first_is_taken(tmp_path):
    twice = BUOY.replace(
        "2   7     4     3      60e3", "1   1     1     13     0\n1   7     4  0 60e3"
    )
    scene, remarks = scene_of(tmp_path, twice)
    breaks = [(event["breaks"], event.get("start")) for event in scene["events"].values()]
    assert breaks == [("line1.start", 12), ("line4.start", None)]
    assert "not taken over: failure 1_, after another one there" in remarks
    # two lines that hold each other: what lets go of one lets go of both
    text = RODS.replace("2   cable  2   R2A", "2   cable  1   2  ")
    text = text.replace("--- OPTIONS", FAILS + "--- OPTIONS")
    scene, remarks = scene_of(tmp_path, text)
    assert list(scene["events"]) == ["failure1"]
    assert remarks[-1] == "not taken over: failure 2, after another one there"


def test_names_as_moordyn_takes_them(tmp_path):
    plain, _ = scene_of(tmp_path, BUOY)
    other = BUOY.replace("1   rope  1  4", "1   R4(1) C1 Con4").replace("rope  0.05", "R4(1) 0.05")
    other = other.replace("rope ", "R4(1) ").replace("6   body1", "6   Body01")
    found, _ = scene_of(tmp_path, other)
    assert found["lines"]["line1"] == plain["lines"]["line1"] | {"material": "R4_1_"}
    assert found["bodies"] == plain["bodies"]


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("1   Free ", "1   Pinned ", 10, "expected a body that is fixed, coupled or free, found"),
        ("0.3|0.1|-0.5", "0.3|0.1", 10, "body 1: expected one number or three, x|y|z, found '0.3|0.1'"),
        ("2000  0.3|0.1|-0.5  1500|1800|1200", "0 0 0", 10,
         "a free body with mass and moments of inertia above 0"),
        ("4       2    0.6", "4       2", 10, "bodies: expected at least 14 columns, found 13"),
        ("1   Body2", "1   Body9", 16, "fixed, coupled, free or on a body, found 'Body9'"),
        ("1   P1    1 ", "1   P12   1 ", 36, "failure 1: expected the number of a point, found 'P12'"),
        ("1   P1    1 ", "1   R1a   1 ", 36, "failure 1: expected the number of a point, found 'R1a'"),
        ("1   P1    1 ", "1   P1    9 ", 36, "failure 1: expected the number of a line, found '9'"),
        ("1   P1    1 ", "1   P1    2 ", 36, "expected a line that ends at point 1, found line 2"),
        ("12     0", "0      0", 36, "failure 1: expected a time or a tension above 0, found neither"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_line(tmp_path, old, new, line, words):
    assert old in BUOY
    tells(tmp_path, BUOY.replace(old, new, 1), line, words)


def test_a_body_that_no_line_holds_is_told(tmp_path):
    loose = BUOY.replace("2   Fixed   ", "4 Free 0 0 -9 0 0 0 50 0 9 0 0 0\n2   Fixed   ", 1)
    scene, remarks = scene_of(tmp_path, loose)
    assert "not taken over: body 4, which no line holds" in remarks
    assert "body4" not in scene["bodies"]


@pytest.mark.slow
def test_a_buoy_rests_where_moordyn_has_it(tmp_path):
    text = BUOY[: BUOY.index("--- FAILURE")]
    text += (
        "--- OPTIONS\n0.0005 dtM\n50 WtrDpth\n1 ICgenDynamic\n600 TmaxIC\n1e-7 threshIC\n--- need\n"
    )
    # a coupled body would ask for its motion as well
    text = text.replace("3   Coupled ", "3   Fixed   ").replace("-1   7 ", "-1   0 ")
    scene_of(tmp_path, text)
    (outcome,) = run_study(load_study(tmp_path / "mooring.toml"), tmp_path / "rest.h5")
    assert outcome.status.name == "OK"
    with moordyn_at_rest(tmp_path, (10.0, 0.0, -5.0)) as (moordyn, system):
        place = np.array(moordyn.GetBodyState(moordyn.GetBody(system, 1))[0])
        pulls = [moordyn.GetLineFairTen(moordyn.GetLine(system, k)) for k in (1, 2, 3)]
    turn = Rotation.from_euler("XYZ", place[3:])
    with open_result(tmp_path / "rest.h5") as result:
        own, angles = (result.body("body1", key)[0, 0] for key in ("position", "attitude"))
        found = [result.line(f"line{k}").tension(0)[0, -1] for k in (1, 2, 3)]
    assert own == pytest.approx(place[:3] + turn.apply([0.3, 0.1, -0.5]), abs=2e-3)
    apart = Rotation.from_euler("xyz", angles).inv() * turn
    assert np.degrees(apart.magnitude()) < 0.05
    assert found == pytest.approx(pulls, rel=1e-3)
