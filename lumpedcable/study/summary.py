"""The numbers that a run comes down to: how it ended, what recoiled how fast, whether energy closed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from lumpedcable.exact import release_wave
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.materials import law_of
from lumpedcable.model.model import END_NAMES
from lumpedcable.scene import Scene, Study, TableMaterial
from lumpedcable.solve.integrate import Progress
from lumpedcable.solve.observe import Recoil, Sample
from lumpedcable.status import ADVICE, MEANING, Status
from lumpedcable.study.carried import measure_outcome
from lumpedcable.study.compiled import Ready
from lumpedcable.study.plan import recoils_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from lumpedcable.study.run import Part

__all__ = ["EXACT", "QUANTITIES", "Account", "Outcome", "recoil_name", "recoil_names", "summarise"]

QUANTITIES = {
    "static_strain": ("1", "strain at the end before the break"),
    "static_tension": ("N", "tension at the end before the break"),
    "peak_end_speed": ("m/s", "peak speed of the broken end"),
    "break_start": ("s", "time at which the break begins"),
    "front_arrival": (
        "s",
        "time after the start of the break until the far end has lost 1 % of its tension",
    ),
    "end_displacement": ("m", "distance of the broken end from its start, at the last time"),
}
EXACT = {
    "static_strain": ("1", "strain of a straight line under that tension", "no weight"),
    "peak_end_speed": (
        "m/s", "speed of the broken end in the exact wave", "instantaneous break, no drag, no weight"),
    "front_arrival": (
        "s", "time at which the exact wave front reaches the far end",
        "instantaneous break, no drag, no weight"),
}  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """How a run ended, and its numbers (SI); NaN where the run did not get that far."""

    run: int
    status: Status
    status_time: float
    message: str
    steps: int
    solver_step: float
    energy_closure: float
    released_energy: float
    static_imbalance: float
    residual: NDArray[np.float64]
    recoils: Mapping[str, Mapping[str, float]]
    measures: Mapping[str, float] = field(default_factory=dict)


def recoil_name(recoil: Recoil) -> str:
    """ "rope.end" for the end of rope."""
    return f"{recoil.line}.{END_NAMES[recoil.node]}"


def recoil_names(layout: Layout) -> list[str]:
    """Names of all recoiling ends of a layout."""
    return [recoil_name(recoil) for recoil in recoils_of(layout)]


# share of the released energy beyond which a run is not to be trusted: what is resolved stays below
# a hundredth, what runs away gains tens of per cents and then multiples
ENERGY_LIMIT = 0.05


class Account:
    """What is kept of a part's runs for their summaries: histories of scalars and of the ends."""

    def __init__(self, part: Part, count: int, coordinates: Coordinates):
        self.part, self.count, self.coordinates = part, count, coordinates
        runs = len(part.runs)
        self.energy: dict[str, NDArray[np.float64]] = {}
        self.measures: dict[str, NDArray[np.float64]] = {}
        self.flags = {
            key: np.zeros((runs, count + 1), bool) for key in ("finite", "reversed", "exhausted")
        }
        self.courant = np.zeros((runs, count + 1))
        self.last: Sample | None = None
        self.reached = 0
        self.watches: tuple[Any, ...] = ()
        self._start: dict[str, NDArray[np.float64]] | None = None

    def add(self, samples: Sample, first: int, count: int) -> None:
        """Samples (runs, count, ...) from output `first` on."""
        times = slice(first, first + count)
        for key, table in self.flags.items():
            table[:, times] = getattr(samples, key)
        self.courant[:, times] = samples.courant
        for term, values in samples.energy.items():
            shape = (len(self.part.runs), self.count + 1)
            self.energy.setdefault(term, np.full(shape, np.nan))[:, times] = values
        for name, values in samples.measures.items():
            shape = (len(self.part.runs), self.count + 1)
            self.measures.setdefault(name, np.full(shape, np.nan))[:, times] = values
        self.last = jax.tree.map(lambda x: x[:, -1], samples)
        self.reached = first + count - 1

    def finish(self, run: Progress) -> None:
        """The state at the end of all outputs."""
        self.watches = jax.tree.map(np.asarray, run.seen)
        self.displacement = jax.tree.map(np.asarray, run.y.displacement)

    def start_positions(self, ready: Ready) -> dict[str, NDArray[np.float64]]:
        """Positions (runs, 3, nodes) of every line at the start (m)."""
        if self._start is None:
            self._start = {
                name: self.coordinates.expand(np.asarray(line.reference, float), 1, place=True)
                for name, line in ready.model.lines.items()
            }
        return self._start


def summarise(
    study: Study, scenes: list[Scene], part: Part, ready: Ready, account: Account
) -> dict[int, Outcome]:
    """The outcome of every run of a part, whether or not it got to its end."""
    scene = scenes[part.runs[0]]
    times = np.arange(account.count + 1) * scene.output.every
    complete = account.reached == account.count
    outcomes = {}
    for k, run in enumerate(part.runs):
        status, when = _status(account, k, bool(np.asarray(ready.converged)[k]), times)
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blew up has such energies
            residual, closure, released = _balance(account, k, status, when, times)
        open_ = np.abs(residual) > max(ENERGY_LIMIT * released, _tolerated(account, k))
        if status is Status.OK and open_.any():
            status, when = Status.ENERGY_NOT_CLOSED, float(times[np.argmax(open_)])
        if status is Status.OK and not complete:
            status, when = Status.INTERRUPTED, times[account.reached]
        message = MEANING[status]
        if status is not Status.OK:
            at = "" if not np.isfinite(when) else f" at {1e3 * when:.6g} ms"
            message = f"{message}{at}; {ADVICE[status]}"
        recoils = {}
        for index, recoil in enumerate(part.plan.recoils):
            numbers = _recoil(scenes[run], ready, account, recoil, index, k, status, when, complete)
            recoils[recoil_name(recoil)] = numbers
        seen = times < when if np.isfinite(when) else np.full(times.shape, True)
        measures = {
            name: measure_outcome(scenes[run], name, table[k][seen])
            for name, table in account.measures.items()
        }
        step = float(np.nan) if part.plan.adaptive else scene.output.every / part.steps
        outcomes[run] = Outcome(
            run, status, when, message, part.steps * account.count, step, closure, released,
            float(np.asarray(ready.imbalance)[k]), residual, recoils, measures,
        )  # fmt: skip
    return outcomes


def _status(account: Account, k: int, converged: bool, times) -> tuple[Status, float]:
    """The first thing that went wrong, and when (s)."""
    if not converged:
        return Status.STATICS_NOT_CONVERGED, 0.0
    seen = slice(0, account.reached + 1)
    signs = {
        Status.NON_FINITE: ~account.flags["finite"][k, seen],
        Status.STEP_BOUND_BROKEN: account.courant[k, seen] > 1.0,
        Status.LINE_REVERSED: account.flags["reversed"][k, seen],
        Status.TOO_MANY_STEPS: account.flags["exhausted"][k, seen],
    }
    found = [(int(np.argmax(flag)), status) for status, flag in signs.items() if flag.any()]
    if not found:
        return Status.OK, float("nan")
    # what is undefined was something else first
    order = [Status.STEP_BOUND_BROKEN, Status.TOO_MANY_STEPS, Status.NON_FINITE,
             Status.LINE_REVERSED]  # fmt: skip
    first, status = min(found, key=lambda f: (f[0], order.index(f[1])))
    return status, float(times[first])


def _balance(account: Account, k: int, status: Status, when: float, times):
    """Residual history (J), its largest share of the released energy, and that energy (J)."""
    residual = np.full(account.count + 1, np.nan)
    if not account.energy or status is Status.STATICS_NOT_CONVERGED:
        return residual, float("nan"), float("nan")
    terms = {name: table[k] for name, table in account.energy.items()}
    work = sum((v for n, v in terms.items() if n.startswith("work_")), np.zeros_like(times))
    lost = sum((v for n, v in terms.items() if n.startswith("lost_")), np.zeros_like(times))
    stored = np.zeros_like(times)
    for name, table in terms.items():
        if not name.startswith(("work_", "lost_")):
            stored = stored + table
    residual = stored - stored[0] - work + lost
    usable = np.isfinite(residual)
    if np.isfinite(when):
        usable &= times < when
    usable[0] = True
    moved = terms["kinetic"] + lost
    released = float(np.nanmax(np.where(usable, moved, 0.0)))
    worst = float(np.nanmax(np.where(usable, np.abs(residual), 0.0)))
    return residual, worst / released if released > 0.0 else 0.0, released


def _tolerated(account: Account, k: int) -> float:
    """Energy (J) that a run may leave open however little it has released.

    A hundredth of the strain energy that it starts with, so that the first steps of a break are no
    alarm; and what rounding can do, which is all that a line at rest has.
    """
    peaks = {
        n: float(np.nanmax(np.abs(table[k]), initial=0.0)) for n, table in account.energy.items()
    }
    rounding = 1e6 * float(np.finfo(account.part.plan.dtype).eps) * max(peaks.values(), default=0.0)
    strain = account.energy.get("strain")
    return rounding if strain is None else max(0.01 * float(strain[k][0]), rounding)


def _recoil(
    scene: Scene, ready: Ready, account: Account, recoil: Recoil, index: int, k: int,
    status: Status, when: float, complete: bool,
) -> dict[str, float]:  # fmt: skip
    """Numbers of one recoiling end, measured and exact."""
    line = ready.model.lines[recoil.line]
    strain = float(np.asarray(line.reference_strain)[k, recoil.node])
    tension_of = _curve(scene, _source(scene, recoil.line))
    tension = float(tension_of(np.asarray([strain]))[0])
    begins = _begins(scene, account.part.batch.structure.layout, recoil)
    numbers = dict.fromkeys(QUANTITIES, float("nan")) | {"break_start": begins}
    if status is not Status.STATICS_NOT_CONVERGED:
        numbers |= {"static_strain": strain, "static_tension": tension}
    usable = complete and status is not Status.STATICS_NOT_CONVERGED
    if usable:
        watch = account.watches[index]
        arrival = float(watch.arrival[k])
        # a far end that lost tension before the break lost it to something else
        if arrival >= begins and (not np.isfinite(when) or arrival < when):
            numbers["front_arrival"] = arrival - begins
        if not np.isfinite(when) or float(watch.peak_time[k]) < when:
            numbers["peak_end_speed"] = float(watch.peak_speed[k])
        if status is Status.OK:
            move = account.displacement[recoil.line][k][:, recoil.node]
            numbers["end_displacement"] = float(np.linalg.norm(move))
    # after an earlier break the line is no longer at rest under this tension
    first = all(event.start >= begins for event in scene.events.values())
    exact = {}
    if tension > 0.0 and first:
        exact = _exact(scene, ready, recoil, k, tension, tension_of)
    return numbers | {f"exact_{name}": exact.get(name, float("nan")) for name in EXACT}


def _begins(scene: Scene, layout: Layout, recoil: Recoil) -> float:
    """When the break of a recoiling end begins (s)."""
    joint = layout.joint_of(recoil.line, recoil.node)
    members = ((recoil.line, recoil.node),) if joint is None else layout.joints[joint].members
    events = [layout.event_at(*member) for member in members]
    return min(scene.events[event].start for event in events if event is not None)


def _source(scene: Scene, piece: str) -> str:
    """The scene's line that a piece belongs to: "rope" for "rope" and for "rope-2"."""
    return piece if piece in scene.lines else piece.rpartition("-")[0]


def _curve(scene: Scene, line: str) -> Callable[[ArrayLike], NDArray[np.float64]]:
    """The tension law of a line (N over strain) as a plain function, cut at zero where it is."""
    material = scene.materials[scene.lines[line].material]
    if isinstance(material, TableMaterial):
        # the engine's smooth interpolation, not the straight one between the points
        law = law_of(material)
        curve = jax.jit(lambda strain: law.tension(strain))
        return lambda strain: np.asarray(curve(jnp.asarray(strain, float)))

    def tension(strain: ArrayLike) -> NDArray[np.float64]:
        value = material.curve(np.asarray(strain, float))
        return np.maximum(value, 0.0) if material.tension_only else value

    return tension


def _exact(
    scene: Scene, ready: Ready, recoil: Recoil, k: int, tension: float,
    tension_of: Callable[[ArrayLike], NDArray[np.float64]],
) -> dict[str, float]:  # fmt: skip
    """The exact release wave of a straight uniform line from the same tension (N)."""
    line = ready.model.lines[recoil.line]
    lengths = np.asarray(line.segment_length)[k]
    length = float(np.sum(np.broadcast_to(lengths, (line.reference.shape[-1] - 1,))))
    mass = scene.lines[_source(scene, recoil.line)].mass
    try:
        wave = release_wave(tension_of, mass, tension0=tension)
    except ValueError:
        return {}  # a law that falls somewhere has no single wave
    return {
        "static_strain": wave.strain0,
        "peak_end_speed": wave.end_speed,
        "front_arrival": wave.front_arrival(length),
    }
