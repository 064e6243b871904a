"""A mooring rope that falls slack at every swing of its fairlead, beside MoorDyn itself."""

from contextlib import chdir

import numpy as np
import pytest
from adopted import scene_of

from benchmarks.peers.moordyn_chain import quiet
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

POLYESTER = """\
--- polyester between an anchor and a ship
--- LINE TYPES
Name  Diam  Mass EA BA EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s/-) (N-m2) (-) (-) (-) (-)
poly 0.16 18 9e7 -0.8 0 1.2 1.0 0.05 0
--- POINTS
ID Type X Y Z Mass Volume CdA Ca
(#) (-) (m) (m) (m) (kg) (m3) (m2) (-)
1 Fixed 300 200 -250 0 0 0 0
2 Coupled 20 10 -15 0 0 0 0
--- LINES
ID Type A B UnstrLen NumSegs Outputs
(#) (-) (#) (#) (m) (-) (-)
1 poly 1 2 416 30 -
--- OPTIONS
250 WtrDpth
3e5 kBot
3e4 cBot
0.0005 dtM
200 TmaxIC
1e-6 threshIC
1 ICgenDynamic
0 writeLog
--- need this line
"""
FAIRLEAD, SWING = np.array([20.0, 10.0, -15.0]), np.array([2.0, 0.0, 1.0])
PERIOD, TIME, EVERY = 6, 28, 0.1


def place(t):
    """Where the fairlead is (m), its swing grown over a period."""
    grown = np.sin(0.5 * np.pi * min(t / PERIOD, 1.0)) ** 2
    return FAIRLEAD + grown * np.sin(2.0 * np.pi * t / PERIOD) * SWING


def by_moordyn(folder, step=5e-4):
    """Tension (N) of the last segment every 0.1 s."""
    moordyn = pytest.importorskip("moordyn")
    found = []
    with quiet(), chdir(folder):
        system = moordyn.Create("mooring.txt")
        try:
            here = place(0.0)
            moordyn.Init(system, here.tolist(), [0.0] * 3)
            line = moordyn.GetLine(system, 1)
            for k in range(round(TIME / step) + 1):
                if k % round(EVERY / step) == 0:
                    found.append(np.linalg.norm(moordyn.GetLineNodeTen(line, 30)))
                there = place((k + 1) * step)
                velocity = ((there - here) / step).tolist()
                moordyn.Step(system, there.tolist(), velocity, k * step, step)
                here = there
        finally:
            moordyn.Close(system)
    return np.array(found)


@pytest.mark.slow
def test_it_snaps_as_hard_as_in_moordyn(tmp_path):
    # both lose their tension at every swing; what pulled there would damp the snap that follows
    scene_of(tmp_path, POLYESTER)
    motion = "{surge={amplitude=2,period=6},heave={amplitude=1,period=6},ramp=6}"
    change = f"bodies.vessel.motion={motion}", f"output={{duration={TIME},every={EVERY}}}"
    (outcome,) = run_study(load_study(tmp_path / "mooring.toml", change), tmp_path / "moved.h5")
    assert outcome.status.name == "OK"
    with open_result(tmp_path / "moved.h5") as result:
        own = result.line("line1").field("tension")[0]
    theirs, steady = by_moordyn(tmp_path), slice(160, None)
    assert np.mean(own[steady] == 0.0) > 0.05  # slack, somewhere
    assert np.max(own[steady, -1]) == pytest.approx(np.max(theirs[steady]), rel=0.02)
    apart = np.sqrt(np.mean((own[:, -1] - theirs)[steady] ** 2))
    assert apart < 0.15 * np.std(theirs[steady])
