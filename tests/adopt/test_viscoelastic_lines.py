"""Viscoelastic line types of MoorDyn: two springs, two dashpots, as a branch beside a law."""

from contextlib import chdir

import numpy as np
import pytest
from adopted import scene_of, tells

from benchmarks.peers.moordyn_chain import quiet
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

ROPE = """\
--- a rope under tension
--- LINE TYPES
Name  Diam  Mass  EA    BA/-zeta  EI  Cd  Ca  CdAx  CaAx
(-)   (m)  (kg/m) (N)   (N-s/-)  (N-m2) (-) (-) (-)  (-)
rope  0.05  {mass}   {EA}  {BA}      0   {Cd}   {Ca}   0     0
--- POINTS
ID  Type     X     Y  Z    Mass  Volume CdA Ca
(#) (-)      (m)  (m) (m)  (kg)  (m3)  (m2) (-)
1   Fixed    0     0  -50  0     0      0   0
2   Coupled  {x}   0  {z}  0     0      0   0
--- LINES
ID  Type  A  B  UnstrLen NumSegs Outputs
(#) (-)   (#) (#) (m)    (-)     (-)
1   rope  1  2  30       {n}     -
--- OPTIONS
0         writeLog
{step}    dtM
RK2       tScheme
1025      WtrDnsty
9.8       g
100       WtrDpth
0.5       dtIC
60        TmaxIC
1e-9      threshIC
1         ICgenDynamic
--- need this line
"""
EAs, EAd = 1e6, 2.5e6  # N
AFLOAT = 1025.0 * np.pi / 4.0 * 0.05**2  # kg/m


def rope(EA="1e6|2.5e6", BA="2e5|5e4", n=10, **numbers):
    """A rope of n segments, straight since it weighs nothing in water, or with other numbers."""
    straight = {"mass": AFLOAT, "Cd": 0.0, "Ca": 0.0, "x": 30.3, "z": -50.0, "step": 1e-3}
    return ROPE.format(EA=EA, BA=BA, n=n, **straight | numbers)


def in_series(EA, EA_d, BA, BA_d, s):
    """Tension over strain (N) at exp(s t), from the compliances of the two parts one after the other."""
    slow = 1.0 / (1.0 / EA - 1.0 / EA_d)
    return 1.0 / (1.0 / (EA_d + BA_d * s) + 1.0 / (slow + BA * s))


def beside(material, s):
    """The same (N) of a material of a scene, from what it has beside each other."""
    total = material["EA"] + material.get("damping", 0.0) * s
    for branch in material.get("relaxation", {}).values():
        total = total + branch["EA"] * branch["time"] * s / (1.0 + branch["time"] * s)
    return total


@pytest.mark.parametrize(
    ("EA", "EA_d", "BA", "BA_d"),
    [
        (1e6, 2.5e6, 2e5, 5e4),
        (1e6, 2.5e6, 2e5, 0.0),
        (1e6, 2.5e6, 0.0, 5e4),
        (1e6, 1.001e6, 3e3, 7e4),
        (6.5e7, 2.3e8, 6.6e9, 2.2e6),  # as polyester has it: minutes to an hour
    ],
)
def test_a_rope_of_two_parts_is_as_stiff_at_every_frequency(tmp_path, EA, EA_d, BA, BA_d):
    scene, remarks = scene_of(tmp_path, rope(f"{EA!r}|{EA_d!r}", f"{BA!r}|{BA_d!r}"))
    (material,) = scene["materials"].values()
    assert not [remark for remark in remarks if "not taken over" in remark]
    assert (material["law"], material["EA"], material["tension_only"]) == ("linear", EA, True)
    assert ("damping" in material) == (BA > 0.0 and BA_d > 0.0)
    s = 1j * np.logspace(-6.0, 4.0, 41)
    assert beside(material, s) == pytest.approx(in_series(EA, EA_d, BA, BA_d, s), rel=1e-12)


def test_what_moordyn_has_no_dynamic_damping_of_is_undamped_there(tmp_path):
    # MoorDyn takes 0 for it, and writes so
    one, both = (scene_of(tmp_path, rope(BA=text))[0]["materials"] for text in ("2e5", "2e5|0"))
    assert one == both
    # at once the fast spring alone gives, EA_d, and in the end both: the branch has what is in between
    assert one["rope"]["relaxation"]["fast"] == pytest.approx(
        {"EA": EAd - EAs, "time": 2e5 / (EAd + EAd * EAs / (EAd - EAs))}
    )
    assert "damping" not in one["rope"]


@pytest.mark.parametrize(
    ("EA", "BA", "damping"),
    [("1e6|2e6", "5e5|5e5", 2.5e5), ("1e6|3e6", "3e5|6e5", 2e5), ("1e6|7e6", "7e4|42e4", 6e4)],
)
def test_parts_that_relax_alike_are_one(tmp_path, EA, BA, damping):
    # EA_1 = 2, 3/2, 7/6 MN beside EA_d = 2, 3, 7 MN, damped as one is to the other
    scene, _ = scene_of(tmp_path, rope(EA, BA))
    material = scene["materials"]["rope"]
    assert material.pop("damping") == pytest.approx(damping, rel=1e-15)
    assert material == {"law": "linear", "EA": 1e6, "tension_only": True}


def test_a_share_of_critical_damping_is_that_of_the_static_part(tmp_path):
    # half of sqrt(EA_s m) l, of segments of 3 and of 5 m: two materials of one type
    text = rope(BA="-0.5|5e4").replace("--- OPTIONS", "2 rope 1 2 30 6 -\n--- OPTIONS")
    scene, _ = scene_of(tmp_path, text)
    s = 1j * np.logspace(-2.0, 3.0, 11)
    assert list(scene["materials"]) == ["rope", "rope_2"]
    for material, length in zip(scene["materials"].values(), (3.0, 5.0), strict=True):
        static = 0.5 * length * np.sqrt(EAs * AFLOAT)
        assert beside(material, s) == pytest.approx(in_series(EAs, EAd, static, 5e4, s), rel=1e-12)


@pytest.mark.parametrize(
    ("EA", "BA", "words"),
    [
        ("2.5e6|1e6", "2e5|5e4", "EA of rope: expected a dynamic stiffness above the static one, "
         "EA_s|EA_d, found '2.5e6|1e6'"),
        ("1e6|1e6", "2e5|5e4", "expected a dynamic stiffness above the static one"),
        ("1e6|2e6|3", "2e5|5e4", "EA of rope: expected one number or two, EA_s|EA_d, found '1e6|2e6|3'; "
         "of one that goes with the load, give EA_d at the load that the line carries"),
        ("1e6|", "2e5|5e4", "EA of rope: expected a number, found ''"),
        ("1e6|-2e6", "2e5|5e4", "EA of rope: expected a positive number, found '-2e6'"),
        ("1e6|2e6", "0|0", "BA of rope: expected damping BA_s|BA_d beside EA_s|EA_d, one of them above "
         "0, found '0|0'"),
        ("1e6|2e6", "0", "expected damping BA_s|BA_d beside EA_s|EA_d, one of them above 0, found '0'"),
        ("1e6|2e6", "2e5|-0.1", "dynamic BA of rope: expected a number from 0 on, found '-0.1'"),
        ("1e6|2e6", "2e5|x", "dynamic BA of rope: expected a number, found 'x'"),
        ("1e6|2e6", "x|0", "BA of rope: expected a number, found 'x'"),
        ("1e6|2e6", "1|2|3", "BA of rope: expected one number or two, BA_s|BA_d, found '1|2|3'"),
        ("1e6", "2e5|5e4", "BA of rope: expected one number, as there is one EA, found '2e5|5e4'"),
    ],
)  # fmt: skip
def test_what_is_no_such_rope_is_told_with_its_line(tmp_path, EA, BA, words):
    tells(tmp_path, rope(EA, BA), 5, words)


# --- under way ------------------------------------------------------------------------------------


def pulls(folder, text, motion, step, *overrides, every=0.01):
    """Times (s) and tensions (N) of a file's segments whose vessel moves for two seconds."""
    scene_of(folder, text)
    change = (
        f"bodies.vessel.motion={{{motion}}}",
        "output.duration=2",
        f"output.every={every}",
        f"solver.step={step}",
        *overrides,
    )
    run_study(load_study(folder / "mooring.toml", list(change)), folder / "moved.h5")
    with open_result(folder / "moved.h5") as result:
        found = result.time, result.line("line1").field("tension")[0]
    (folder / "moved.h5").unlink()
    return found


@pytest.mark.slow
def test_a_segment_that_is_pulled_to_and_fro_answers_with_the_modulus(tmp_path):
    # 0.1 m on 30, six a second: the modulus is what is in phase and what is ahead
    omega, apart = 6.0, []
    motion = f"surge = {{ amplitude = 0.1, period = {2.0 * np.pi / omega!r} }}"
    expected = in_series(EAs, EAd, 2e5, 5e4, 1j * omega)
    for step in (2e-3, 1e-3):
        t, tension = pulls(tmp_path, rope(n=1), motion, step)
        late = t > 2.0 - 2.0 * np.pi / omega  # 15 times as long as the branch takes
        waves = np.stack([np.sin(omega * t), np.cos(omega * t), np.ones_like(t)], axis=1)
        ahead, beside_it, _ = np.linalg.lstsq(waves[late], tension[late, 0])[0]
        found = (ahead + 1j * beside_it) / (0.1 / 30.0)
        apart.append(abs(found - expected) / abs(expected))
    # the dashpots go by steps of second order
    assert apart[1] < 1e-5
    assert apart[1] < 0.3 * apart[0]


def pulls_by_moordyn(folder, text, step, axis, amplitude, period, start):
    """Times (s) and tensions (N) of the two end segments, of the same file by MoorDyn itself.

    The moved end is handed over at every step, with the velocity that leads to its next place. What
    MoorDyn then tells is of the middle of the step, where its method of second order was last.
    """
    moordyn = pytest.importorskip("moordyn")
    (folder / "rope.txt").write_text(text)
    along = np.eye(3)[axis]
    with quiet(), chdir(folder):
        system = moordyn.Create("rope.txt")
        try:
            here, found = np.array(start), []
            moordyn.Init(system, here.tolist(), [0.0] * 3)
            line = moordyn.GetLine(system, 1)
            last = moordyn.GetLineN(line)
            for k in range(round(2.0 / step)):
                swing = amplitude * np.sin(2.0 * np.pi * (k + 1) * step / period)
                there = np.array(start) + swing * along
                velocity = ((there - here) / step).tolist()
                moordyn.Step(system, here.tolist(), velocity, k * step, step)
                ends = [np.linalg.norm(moordyn.GetLineNodeTen(line, i)) for i in (0, last)]
                found.append(((k + 0.5) * step, *map(float, ends)))
                here = there
        finally:
            moordyn.Close(system)
    t, *tension = np.array(found).T
    return t, np.array(tension)


HUNG = {"mass": 6.0, "Cd": 1.2, "Ca": 1.0, "x": 29.0, "z": -45.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("EA", "BA", "numbers", "axis", "amplitude", "period"),
    [
        ("1e6|2.5e6", "2e5|2e3", {}, "surge", 0.1, 0.8),
        ("2e5|6e5", "4e4|1e3", HUNG, "heave", 0.25, 1.5),
    ],
    ids=["straight", "hung"],
)
def test_a_rope_that_is_shaken_pulls_as_it_does_in_moordyn(
    tmp_path, EA, BA, numbers, axis, amplitude, period
):
    def text(step):
        return rope(EA, BA, 12, **numbers, step=step)

    motion = f"{axis} = {{ amplitude = {amplitude}, period = {period} }}"
    t, mine = pulls(tmp_path, text(1e-3), motion, 2.5e-4)
    _, elastic = pulls(tmp_path, text(1e-3), motion, 1e-3, "materials.rope.relaxation={}")
    # the first second has the jump of speed in it with which the motion begins
    late = t > 1.0
    mine, elastic = (tension[late][:, [0, -1]].T for tension in (mine, elastic))
    assert mine.min() > 0.0
    swing = np.std(mine[1])

    def apart(other):
        return np.sqrt(np.mean((other - mine) ** 2, axis=1)).max() / swing

    start = [numbers.get("x", 30.3), 0.0, numbers.get("z", -50.0)]
    along, found = ("surge", "sway", "heave").index(axis), []
    for step in (1e-3, 5e-4, 2.5e-4):
        at, other = pulls_by_moordyn(tmp_path, text(step), step, along, amplitude, period, start)
        found.append(apart([np.interp(t[late], at, pull) for pull in other]))
    # of first order in MoorDyn's step; without the branch 42 and 75 % of the swing are missing
    assert found[1] < 0.55 * found[0]
    assert found[2] < 0.55 * found[1]
    assert found[2] < 2e-4
    assert apart(elastic) > 0.3
