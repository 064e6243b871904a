"""How a run is stepped, by structure and by numbers, and where it is between two steps."""

from dataclasses import dataclass
from typing import NamedTuple

from jaxtyping import Array, Bool, Float, Int, PyTree

from lumpedcable.model.state import State
from lumpedcable.solve.observe import Recoil, Watch
from lumpedcable.solve.trips import Trip

__all__ = ["Numbers", "Plan", "Progress", "peaks_of"]


@dataclass(frozen=True)
class Plan:
    """How to integrate, as far as it is structure: what it changes needs another compilation.

    `adaptive` steps are the solver's own choice; else each output interval is cut into equal steps.
    Of the ends `tips` place and velocity are sampled.
    `outputs` is the most that one call of `advance` returns, `fields_after` from how many of them to how
    many there are fields again. With `watch_peaks` leapfrog keeps the largest tensions of all segments.
    Of the lines `borne` the largest tension is sampled.
    `sloped` asks that Runge-Kutta methods of fixed steps have derivatives in both modes, which takes a
    little longer, and a run that stops ends at the instant of it.
    """

    method: str
    adaptive: bool
    quantities: tuple[str, ...]
    recoils: tuple[Recoil, ...]
    dtype: str
    max_steps: int
    outputs: int
    stop: str | None = None
    sloped: bool = False
    tips: tuple[Recoil, ...] = ()
    fields_after: int = 1
    watch_peaks: bool = False
    borne: tuple[str, ...] = ()

    @property
    def energy(self) -> bool:
        """Whether energies are accounted for."""
        return "energy" in self.quantities


class Progress(NamedTuple):
    """Where a run is: its state, what its solver keeps between steps, its watches.

    `solver_state` is a `HalfStep` of leapfrog, a `RodHalfStep` of rods, and of adaptive methods the mean
    step (s) of the last interval. `stopped` is when its body came to rest (s), NaN before; `rod_peaks`
    the largest tensions so far of the segments of inextensible lines (N), of others see `peaks_of`;
    `upright` the least |cos(pitch)| so far of bodies that turn in space; `trips` tell when ends that
    break at a tension have to carry it, whether or not they break then. `stuck` is 0 while steps are
    found, else the `Status` of why there was none, and time stands still; a run whose rods have `lost`
    their lengths stays as it was before that step.
    """

    y: State
    solver_state: PyTree
    seen: tuple[Watch, ...]
    stuck: Int[Array, ""]
    stopped: Float[Array, ""]
    rod_peaks: dict[str, Float[Array, " n"]]
    lost: Bool[Array, ""]
    upright: dict[str, Float[Array, ""]] = {}  # noqa: RUF012 (as in `Numbers`)
    trips: dict[str, Trip] = {}  # noqa: RUF012


class Numbers(NamedTuple):
    """The numbers of a plan: output interval (s), steps in it, tolerances.

    `cuts` are, by line, the segments before its seam, where all runs that go together have the same.
    """

    every: Float[Array, ""]
    steps: Int[Array, ""]
    rtol: Float[Array, ""]
    atol: Float[Array, ""]
    cuts: dict[str, Int[Array, ""]] = {}  # noqa: RUF012 (a named tuple's default, which nobody changes)


def peaks_of(plan: Plan, run: Progress) -> dict[str, Float[Array, " n"]]:
    """Largest tensions so far of the segments of lines (N), by line; of those that are watched so."""
    return run.solver_state.peaks if plan.watch_peaks else run.rod_peaks
