"""The parted line by MoorDyn, from the instant at which its end lets go.

Same length, mass and drag (its tangential coefficient has the factor pi of the engine's default); no
gravity, no bed in reach, no added mass. The tension law goes in as a table, of which MoorDyn takes 30
points, straight in between: they stand where the law bends most. It can let an end go but not slowly, so
that it is compared with an instantaneous break alone. Its internal damping, a share of the critical one,
is its only means against ripples.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path

import numpy as np

from benchmarks.measures import COARSE, FINE, Histories, front_time
from benchmarks.peers.moordyn_chain import quiet
from benchmarks.peers.settings import Outcome
from benchmarks.problem import Array, Line, slack_strain

POINTS = 30  # the most that MoorDyn takes
Setting = tuple[str, float, float]
"""Time scheme, step over the time in which a wave crosses a segment, damping ratio."""

# the time scheme and its step hardly matter (see the table); the damping does
SETTINGS: tuple[Setting, ...] = (
    *(("RK2", 0.4, damping) for damping in (0.0, 0.05, 0.1, 0.2, 0.4)),
    ("RK2", 0.2, 0.1),
    ("RK4", 0.8, 0.0),
    ("RK4", 0.8, 0.2),
)

# those that are the best for some error at some pretension, and one with more damping
FINE_SETTINGS: tuple[Setting, ...] = (
    *(("RK2", 0.4, damping) for damping in (0.0, 0.1, 0.2, 0.4)),
    ("RK4", 0.8, 0.0),
)

INPUT = """\
---------------------- a line that parts
---------------------- LINE TYPES
Name   Diam        Mass      EA      BA        EI  Cd    Ca    CdAx   CaAx
(-)    (m)         (kg/m)    (N)     (N-s)     (-) (-)   (-)   (-)    (-)
rope   {diameter}  {mass}    {EA}    {damping} 0   0     0     {Ct}   0
---------------------- POINTS
ID  Type     X      Y      Z      Mass  Volume  CdA  Ca
(#) (-)      (m)    (m)    (m)    (kg)  (m3)    (m2) (-)
1   Fixed    0      0      -50    0     0       0    0
2   Fixed    {end}  0      -50    0     0       0    0
---------------------- LINES
ID  Type   A  B  Length    NumSegs     Outputs
(#) (-)    (#)(#)(m)       (-)         (-)
1   rope   1  2  {length}  {segments}  -
---------------------- OPTIONS
0           writeLog
{step}      dtM
{scheme}    tScheme
1e5         kBot
0.0         cBot
{density}   WtrDnsty
0.0         g
100.0       WtrDpth
1e-3        dtIC
0.0         TmaxIC
---------------------- need this line
"""


def law_table(line: Line) -> tuple[Array, Array]:
    """Strains and tensions (N) of 30 points, dense where the law bends.

    The error of straight pieces between points on a curve is even where the points are spaced by
    |T''|^(-1/2); a floor keeps some of them where the law is straight.
    """
    start = line.strain(line.pull)
    x = np.linspace(slack_strain(line), start, 4001)
    bend = np.sqrt(np.abs(np.gradient(line.slope(x + 1e-9), x)))
    bend += 0.02 * bend.max() + 1e-9
    share = np.concatenate([[0.0], np.cumsum(0.5 * (bend[1:] + bend[:-1]))])
    inner = np.interp(np.linspace(0.0, share[-1], POINTS - 2), share, x)
    strain = np.concatenate([[min(0.0, x[0])], inner, [1.05 * start]])
    if strain[1] <= strain[0]:
        strain = strain[1:]
    return strain, line.tension(strain)


def solve(line: Line, segments: int, setting: Setting, duration: float) -> Outcome:
    """The line in `segments`, after its end has let go."""
    _, share, _ = setting
    crossing = line.length / segments / line.fastest()
    per_output = math.ceil(COARSE / (share * crossing))
    step = COARSE / per_output
    (coarse, warm), (_, again) = (
        _through(line, segments, setting, step, duration, COARSE) for _ in range(2)
    )
    parts = next(
        k
        for k in range(1, per_output + 1)
        if per_output % k == 0 and (COARSE / k <= FINE or k == per_output)
    )
    fine, _ = _through(line, segments, setting, step, duration, COARSE / parts)
    finite = bool(np.isfinite(coarse.velocity).all())
    return Outcome(
        coarse, fine, min(warm, again), 0.0, per_output * round(duration / COARSE), "steps",
        "OK" if finite else "not finite",
    )  # fmt: skip


def _through(
    line: Line, segments: int, setting: Setting, step: float, duration: float, every: float
) -> tuple[Histories, float]:
    import moordyn

    stretched = line.length * (1.0 + line.strain(line.pull))
    with _input(line, segments, setting, step, stretched) as file, quiet():
        system = moordyn.Create(str(file))
        try:
            moordyn.Init(system, [], [])
            rope = moordyn.GetLine(system, 1)
            last = moordyn.GetLineN(rope)
            moordyn.BreakLine(system, moordyn.GetPoint(system, 2), rope)
            # tensions are computed within a step: before the first there are none
            kept = [(line.pull, line.pull, 0.0)]
            begin = time.perf_counter()
            for k in range(round(duration / every)):
                moordyn.Step(system, [], [], k * every, every)
                ends = (moordyn.GetLineNodeTen(rope, i)[0] for i in (0, 1))
                kept.append((*map(abs, ends), moordyn.GetLineNodeVel(rope, last)[0]))
            seconds = time.perf_counter() - begin
            moved = moordyn.GetLineNodePos(rope, last)[0] - stretched
        finally:
            moordyn.Close(system)
    node, next_, velocity = np.array(kept).T
    # a node's tension is the mean of its segments', at an end that of the one there is; at the wall the
    # engine's rule T_0 + (T_0 - T_1) / 8
    tension = node + (node - next_) / 4.0
    time_ = np.arange(node.size) * every
    return Histories(time_, tension, velocity, moved, front_time(time_, tension)), seconds


@contextmanager
def _input(
    line: Line, segments: int, setting: Setting, step: float, stretched: float
) -> Iterator[Path]:
    """Input files in a folder of their own, which MoorDyn wants to be the working one."""
    scheme, _, damping = setting
    strain, tension = law_table(line)
    rows = "\n".join(f"{e:.15e} {T:.15e}" for e, T in zip(strain, tension, strict=True))
    diameter, density = 0.05, 1025.0
    # k = rho d pi Ct / 2 is all that is left of water and diameter
    Ct = line.drag / (0.5 * density * diameter * math.pi)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        Path("law.txt").write_text(f"law\nstrain tension\n(-) (N)\n{rows}", encoding="utf-8")
        file = Path(folder) / "rope.txt"
        text = INPUT.format(
            diameter=diameter, mass=line.mass, EA="law.txt", damping=-damping or 0.0, Ct=Ct,
            end=f"{stretched:.15g}", length=line.length, segments=segments, step=step,
            scheme=scheme, density=density,
        )  # fmt: skip
        file.write_text(text, encoding="utf-8")
        yield file
