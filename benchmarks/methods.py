"""The methods that are compared, as changes of the scene's solver, and one run of one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import jax

from benchmarks.cases import Case
from benchmarks.engine import Runner, scene_of
from benchmarks.measures import Errors, errors
from benchmarks.reference import Reference

# a line that reversed on itself still has a history, whose error shows what that did to it
USABLE = ("OK", "LINE_REVERSED")
MESHES = (25, 50, 100, 200, 400, 800, 1600)
RK4_MESHES = (*MESHES, 3200)  # one more, to tell what 0.1 % takes at the strongest shock
RK4_STRETCH = 1.35  # of leapfrog's largest step: RK4's own limit is 2.83 / 2 = 1.41 of it


class Method(NamedTuple):
    """A way through time: its name in tables, what it changes in the scene, the meshes it is given.

    `stretch` lengthens fixed steps beyond the largest that leapfrog could take. `budget` (s) is all
    the time that it gets, compiling left out.
    """

    name: str
    changes: tuple[str, ...]
    meshes: tuple[int, ...] = MESHES
    stretch: float | None = None
    budget: float = 45.0


def _adaptive(name: str, waves: str = "plain") -> tuple[str, ...]:
    return (f'solver.method="{name}"', f'solver.waves="{waves}"', *TOLERANCE)


# the mesh leaves 0.1 to 10 %: tighter than this costs time alone
TOLERANCE = ("solver.rtol=1e-4", "solver.atol=1e-6")
SLOW = 75.0  # s for methods that choose their step, which get to the end of few meshes
DEFAULT, RK4 = "leapfrog (default)", "RK4, plain"
METHODS = (
    Method(DEFAULT, ()),
    Method("leapfrog, viscosity only", ('solver.waves="viscous"',)),
    Method("leapfrog, plain", ('solver.waves="plain"',)),
    Method(RK4, ('solver.method="rk4"', 'solver.waves="plain"'), RK4_MESHES, RK4_STRETCH, 120.0),
    Method("Tsit5, plain", _adaptive("tsit5"), MESHES[:6], budget=SLOW),
    Method("Dopri8, plain", _adaptive("dopri8"), MESHES[:6], budget=SLOW),
    Method("Kvaerno5, plain", _adaptive("kvaerno5"), MESHES[:3], budget=SLOW),
)


@dataclass(frozen=True)
class Point:
    """One run: who, what, how far from the reference, how long it took.

    Seconds: `compile` of the first call of this program (NaN if it was compiled before the run),
    `warm` the median of `repeats`. `steps` are those taken, `status` what the engine says.
    """

    method: str
    case: str
    segments: int
    errors: Errors
    warm: float
    repeats: int
    compile: float
    steps: int
    status: str
    dtype: str
    device: str

    def record(self) -> dict[str, Any]:
        """What goes into the JSON file."""
        return asdict(self) | {"errors": self.errors._asdict()}


def point(
    method: Method, case: Case, segments: int, reference: Reference, compiled: float | None
) -> Point:
    """Run a method on a case; `compiled` (s) is known if the program has been compiled before."""
    changes = (*case.changes, *method.changes, f"segments={segments}")
    runner = Runner(scene_of(*changes), method.stretch)
    timed = runner.run()
    found = errors(timed.histories, reference.histories, runner.fine())
    return Point(
        method.name, case.name, segments, found, timed.warm, timed.repeats,
        max(timed.first - timed.warm, 0.0) if compiled is None else compiled, timed.steps,
        timed.status.name, runner.plan.dtype, device(),
    )  # fmt: skip


def device() -> str:
    """The device that computes."""
    return jax.devices()[0].device_kind
