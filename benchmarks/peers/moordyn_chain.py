"""A chain mooring under surge, by the engine and by MoorDyn: python -m benchmarks.peers.moordyn_chain.

Both get the same line, bed, motion and coefficients from configs/peers/chain-mooring.toml, so that
what differs is the numerics and what a program calls the fairlead tension: MoorDyn writes the tension
of the last segment, in its middle, and gives the force on the ship, the weight of half a segment
included; the engine continues the tension to the end of the line. Needs `pip install moordyn`.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from lumpedcable.exact import elastic_catenary
from lumpedcable.physics.sea import GRAVITY, SeaState
from lumpedcable.results import open_result
from lumpedcable.scene import HarmonicMotion, LinearMaterial, Scene, load_study
from lumpedcable.scene.ends import FixedEnd, MovingEnd
from lumpedcable.scene.lines import Line
from lumpedcable.study.run import run_study

PEERS = Path(__file__).parents[2] / "configs" / "peers"
SCENE = PEERS / "chain-mooring.toml"
WAVY = PEERS / "chain-in-waves.toml"
MESHES = (41, 82, 164)
WAVES = 5  # steps of MoorDyn in which the water keeps its velocity
LAST = 20.0  # s from here on: the motion has been steady for a period

INPUT = """\
---------------------- MoorDyn input: {title}
---------------------- LINE TYPES
Name   Diam        Mass      EA      BA        EI  Cd    Ca    CdAx   CaAx
(-)    (m)         (kg/m)    (N)     (N-s)     (-) (-)   (-)   (-)    (-)
chain  {diameter}  {mass}    {EA}    {damping} 0   {Cn}  {Can} {Ct}   0
---------------------- POINTS
ID  Type     X      Y      Z      Mass  Volume  CdA  Ca
(#) (-)      (m)    (m)    (m)    (kg)  (m3)    (m2) (-)
1   Fixed    {anchor}             0     0       0    0
2   Coupled  {fairlead}           0     0       0    0
---------------------- LINES
ID  Type   A  B  Length    NumSegs     Outputs
(#) (-)    (#)(#)(m)       (-)         (-)
1   chain  1  2  {length}  {segments}  -
---------------------- OPTIONS
0           writeLog
{waves}           WaveKin
{step}      dtM
{kb}        kBot
{cb}        cBot
0.0         FrictionCoefficient
{density}   WtrDnsty
{gravity}   g
{depth}     WtrDpth
1.0         dtIC
600.0       TmaxIC
4.0         CdScaleIC
1e-6        threshIC
1           ICgenDynamic
---------------------- need this line
"""


class Histories(NamedTuple):
    """Tensions (N) over time (s) at the ship and at the anchor, and the seconds that they took.

    `force` is the force of the line on the ship (N), where the program gives it.
    """

    time: NDArray[np.float64]
    fairlead: NDArray[np.float64]
    anchor: NDArray[np.float64]
    force: NDArray[np.float64] | None
    seconds: float

    def steady(self) -> NDArray[np.float64]:
        """Fairlead tension (N) once the motion is steady."""
        return self.fairlead[self.time >= LAST]


def scene_of(*overrides: str, file: Path = SCENE) -> Scene:
    """The chain with some numbers changed ("KEY=VALUE")."""
    return load_study(file, list(overrides)).runs[0]


def by_engine(*overrides: str, file: Path = SCENE) -> Histories:
    """The chain by lumpedcable; the seconds are those of a second run, statics included."""
    study = load_study(file, list(overrides))
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "chain.h5"
        run_study(study, target)
        target.unlink()
        begin = time.perf_counter()
        run_study(study, target)
        seconds = time.perf_counter() - begin
        with open_result(target) as result:
            line = result.line("chain")
            fairlead, anchor = (line.field(f"{side}_tension")[0] for side in ("end", "start"))
            return Histories(result.time, fairlead, anchor, None, seconds)


def moordyn_input(scene: Scene, step: float) -> str:
    """MoorDyn's input file for the scene, stepping by `step` (s)."""
    line, material, anchor = parts_of(scene)
    bed, water, drag, added = scene.seabed, scene.water, line.drag, line.added_mass
    assert bed is not None
    assert water is not None
    assert drag is not None
    assert added is not None
    assert line.diameter is not None
    motion = motion_of(scene)
    return INPUT.format(
        title=scene.title, diameter=line.diameter, mass=line.mass, EA=material.EA,
        damping=material.damping or 0.0, Cn=drag.normal, Ct=drag.tangential,
        Can=added.normal, anchor=" ".join(map(str, anchor)),
        fairlead=" ".join(map(str, motion.position)), length=line.length, segments=line.segments,
        step=step, kb=bed.stiffness / line.diameter, cb=(bed.damping or 0.0) / line.diameter,
        density=water.density, gravity=scene.gravity, depth=-bed.height,
        waves=int(scene.sea is not None),
    )  # fmt: skip


def parts_of(scene: Scene) -> tuple[Line, LinearMaterial, tuple[float, ...]]:
    """The chain, what it is made of, and where its anchor is (m)."""
    line, material = scene.lines["chain"], scene.materials["chain"]
    assert isinstance(material, LinearMaterial)
    assert isinstance(line.start, FixedEnd)
    return line, material, line.start.fixed


def motion_of(scene: Scene) -> HarmonicMotion:
    """The motion of the fairlead."""
    end = scene.lines["chain"].end
    assert isinstance(end, MovingEnd)
    assert isinstance(end.motion, HarmonicMotion)
    return end.motion


def path_of(motion: HarmonicMotion, t: float) -> NDArray[np.float64]:
    """x(t) (m) of a harmonic motion with a ramp, as docs/scene-language.md defines it."""
    assert motion.amplitude is not None
    assert motion.period is not None
    ramp = 1.0 if motion.ramp is None else np.sin(0.5 * np.pi * min(t / motion.ramp, 1.0)) ** 2
    swing = np.sin(2.0 * np.pi * t / motion.period + motion.phase)
    return np.asarray(motion.position) + ramp * swing * np.asarray(motion.amplitude)


def by_moordyn(scene: Scene, step: float = 1e-3) -> Histories:
    """The chain by MoorDyn, its second-order Runge-Kutta stepping by `step` (s).

    The ship is handed over at every step, with the velocity that leads to its next place: MoorDyn
    extrapolates, and a place that does not fit by 0.04 mm is 13 kN in a segment of 5 m.
    """
    import moordyn

    water = None if scene.sea is None else _water(scene)
    motion, count = motion_of(scene), round(scene.output.duration / step)
    each = round(scene.output.every / step)
    kept: list[tuple[float, ...]] = []
    with tempfile.TemporaryDirectory() as folder, quiet():
        file = Path(folder) / "chain.txt"
        file.write_text(moordyn_input(scene, step), encoding="utf-8")
        system = moordyn.Create(str(file))
        try:
            here = path_of(motion, 0.0)
            moordyn.Init(system, here.tolist(), [0.0] * 3)
            if water is not None:
                moordyn.ExternalWaveKinInit(system)
            line = moordyn.GetLine(system, 1)
            last = moordyn.GetLineN(line)
            begin = time.perf_counter()
            for k in range(count + 1):
                if k % each == 0:
                    ends = [np.linalg.norm(moordyn.GetLineNodeTen(line, i)) for i in (last, 0)]
                    force = np.linalg.norm(moordyn.GetLineNodeForce(line, last))
                    kept.append((k * step, *map(float, (*ends, force))))
                if water is not None and k % WAVES == 0:
                    nodes = np.asarray(moordyn.ExternalWaveKinGetCoordinates(system))
                    told = [x.tolist() for x in water(nodes, (k + 0.5 * WAVES) * step)]
                    moordyn.ExternalWaveKinSet(system, *told, k * step)
                there = path_of(motion, (k + 1) * step)
                speed = (there - here) / step
                moordyn.Step(system, here.tolist(), speed.tolist(), k * step, step)
                here = there
            seconds = time.perf_counter() - begin
        finally:
            moordyn.Close(system)
    t, fairlead, anchor, force = np.array(kept).T
    return Histories(t, fairlead, anchor, force, seconds)


Water = Callable[[NDArray[np.float64], float], tuple[NDArray[np.float64], NDArray[np.float64]]]


def _water(scene: Scene) -> Water:
    """Velocity (m/s) and acceleration (m/s2) of the water at places (n, 3) (m) and a time (s).

    Of a sea of one sine along x, written out anew: only its phase, which is drawn, is the engine's.
    """
    sea = scene.sea
    assert sea is not None
    assert sea.flow is not None
    assert sea.components == 1
    assert sea.direction == 0.0
    assert sea.depth is not None
    amplitude, omega, depth = sea.height / 4.0 * np.sqrt(2.0), 2.0 * np.pi / sea.period, sea.depth
    drawn = SeaState.of(sea.height, sea.period, sea.gamma, sea.seed, 1)  # type: ignore[arg-type]
    phase, ramp, surface = float(drawn.phase[0]), sea.flow.ramp, scene.sea_level
    number = brentq(
        lambda k: GRAVITY * k * np.tanh(k * depth) - omega**2, 1e-6, 10.0 * omega**2, xtol=1e-14
    )

    def water(places: NDArray[np.float64], t: float):
        share = 1.0 if ramp is None else np.sin(0.5 * np.pi * min(t / ramp, 1.0)) ** 2
        up = number * (np.clip(places[:, 2] - surface, -depth, 0.0) + depth)
        level, upright = np.cosh(up), np.sinh(up)
        angle = omega * t - number * places[:, 0] + phase
        fast = share * amplitude * omega / np.sinh(number * depth)
        still = np.zeros(len(places))
        velocity = [fast * level * np.cos(angle), still, -fast * upright * np.sin(angle)]
        rate = [-level * np.sin(angle), still, -upright * np.cos(angle)]
        return np.stack(velocity, axis=1), fast * omega * np.stack(rate, axis=1)

    return water


@contextmanager
def quiet() -> Iterator[None]:
    """Silence a library that writes to the terminal past Python."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def run(quick: bool) -> dict[str, Any]:
    """Both programs on every mesh; of MoorDyn nothing where it is not installed.

    A distance is the root mean square of the difference of two fairlead histories (N) once the
    motion is steady, over that of the reference about its mean: to the other program on the same
    mesh, and to the same program on the finest mesh.
    """
    meshes = MESHES[:2] if quick else MESHES
    there = importlib.util.find_spec("moordyn") is not None
    found: dict[str, dict[int, Histories]] = {"lumpedcable": {}, "MoorDyn": {}}
    for segments in meshes:
        change = f"segments={segments}"
        found["lumpedcable"][segments] = by_engine(change)
        if there:
            step = 1e-3 * min(1.0, 82 / segments)
            found["MoorDyn"][segments] = by_moordyn(scene_of(change), step)
    runs = []
    for segments in meshes:
        for program, other in (("lumpedcable", "MoorDyn"), ("MoorDyn", "lumpedcable")):
            if segments not in found[program]:
                continue
            mine = found[program][segments]
            steady, force = mine.steady(), mine.force
            runs.append(
                {
                    "program": program,
                    "segments": segments,
                    "rest": float(mine.fairlead[0]),
                    "force_at_rest": None if force is None else float(force[0]),
                    "largest": float(steady.max()),
                    "smallest": float(steady.min()),
                    "anchor_at_rest": float(mine.anchor[0]),
                    "to_other": _maybe(mine, found[other].get(segments)),
                    "to_finest": _maybe(mine, found[program][meshes[-1]]),
                    "seconds": mine.seconds,
                }
            )
    version = importlib.metadata.version("moordyn") if there else None
    return {"quick": quick, "moordyn": version, "exact": list(exact()), "runs": runs}


def exact() -> tuple[float, float]:
    """Tension at fairlead and anchor at rest (N), of the elastic catenary on the seabed."""
    scene = scene_of()
    line, material, anchor_place = parts_of(scene)
    water = scene.water
    assert water is not None
    assert line.diameter is not None
    assert scene.gravity is not None
    weight = (line.mass - water.density * np.pi / 4.0 * line.diameter**2) * scene.gravity
    across = np.asarray(motion_of(scene).position) - np.asarray(anchor_place)
    span = float(np.hypot(across[0], across[1]))
    shape = elastic_catenary(span, float(across[2]), line.length, material.EA, weight, seabed=0.0)
    anchor, fairlead = (float(t) for t in shape.tension([0.0, line.length]))
    return fairlead, anchor


def distance(history: Histories, reference: Histories) -> float:
    """Root mean square difference of two steady fairlead tensions over the reference's swing (-)."""
    other = reference.steady()
    swing = np.sqrt(np.mean((other - other.mean()) ** 2))
    return float(np.sqrt(np.mean((history.steady() - other) ** 2)) / swing)


def _maybe(history: Histories, reference: Histories | None) -> float | None:
    return None if reference is None or reference is history else distance(history, reference)


def table(data: dict[str, Any]) -> str:
    """What `run` found, as a Markdown table (tensions in kN)."""
    fairlead, anchor = (value / 1e3 for value in data["exact"])
    rows = [
        "| program | segments | fairlead at rest, kN | anchor at rest | largest | smallest"
        " | to the other | to its finest | time, s |",
        "|---|---|---|---|---|---|---|---|---|",
        f"| exact catenary | | {fairlead:.2f} | {anchor:.2f} | | | | | |",
    ]
    for each in data["runs"]:
        rest = f"{each['rest'] / 1e3:.2f}"
        if each["force_at_rest"] is not None:
            rest += f" (force on the ship {each['force_at_rest'] / 1e3:.2f})"
        numbers = [f"{each[key] / 1e3:.1f}" for key in ("largest", "smallest")]
        apart = [
            "" if each[key] is None else f"{100.0 * each[key]:.2f} %"
            for key in ("to_other", "to_finest")
        ]
        anchor_rest, seconds = f"{each['anchor_at_rest'] / 1e3:.2f}", f"{each['seconds']:.2f}"
        head = [each["program"], str(each["segments"]), rest, anchor_rest]
        cells = [*head, *numbers, *apart, seconds]
        rows.append("| " + " | ".join(cells) + " |")
    if data["moordyn"] is None:
        rows.append("\nMoorDyn is not installed: `pip install moordyn`.")
    return "\n".join(rows)


def main() -> None:
    """Print the table."""
    print(table(run(quick=False)))


if __name__ == "__main__":
    main()
