"""What is kept of runs on their way for the numbers they come down to: energies, checks, watches."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.seams import parts_of
from lumpedcable.solve.observe import Sample
from lumpedcable.solve.plan import Progress, peaks_of
from lumpedcable.solve.signs import signs
from lumpedcable.status import SIGNS, Status
from lumpedcable.study.compiled import Ready

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.part import Part

__all__ = ["Account", "Balance", "balance", "statuses"]

# losses that are gains where something drives: a thruster, a winch, a current
GIVERS = ("lost_control", "lost_drag", "lost_hull")
# share of the released energy beyond which a run is not to be trusted: what is resolved stays below
# a hundredth, what runs away gains tens of per cents and then multiples
ENERGY_LIMIT = 0.05
AT_REST = 2e-10  # share of the largest energy that is nothing
DIGITS = 64.0  # times the relative precision, to which an energy is told


class Account:
    """What is kept of a part's runs for their summaries: histories of scalars and of the ends."""

    def __init__(self, part: Part, count: int, coordinates: Coordinates):
        self.part, self.count, self.coordinates = part, count, coordinates
        shape = (len(part.runs), count + 1)
        self.energy: dict[str, NDArray[np.float64]] = {}
        self.measures: dict[str, NDArray[np.float64]] = {}
        self.largest: dict[str, NDArray[np.float64]] = {}
        self.signs = {sign: np.zeros(shape, bool) for sign in SIGNS}
        self.reached = -1
        self.watches: tuple[Any, ...] = ()
        self.displacement: dict[str, NDArray[np.float64]] = {}
        self.stopped: NDArray[np.float64] = np.full(len(part.runs), np.nan)
        self.peaks: dict[str, NDArray[np.float64]] = {}
        # by event that begins at a tension, when it did in each run (s), inf where it has not
        self.starts: dict[str, NDArray[np.float64]] = {}
        # strain (-) and tension (N) at rest of recoiling ends of lines with loads, (runs, 2)
        self.rests: dict[str, NDArray[np.float64]] = {}
        self._start: dict[str, NDArray[np.float64]] | None = None
        self._finished = False

    @property
    def _tables(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """What samples have by name, as they call it."""
        return {"energy": self.energy, "largest": self.largest, "measures": self.measures}

    @property
    def complete(self) -> bool:
        """Whether all outputs were reached, and the state at their end was looked at."""
        return self._finished

    def add(self, samples: Sample, first: int, count: int) -> None:
        """Samples (runs, count, ...) from output `first` on."""
        times = slice(first, first + count)
        shape = (len(self.part.runs), self.count + 1)
        finite = samples.finite
        for values in samples.energy.values():  # of places beyond all measure, before all else
            finite = finite & np.isfinite(values)
        for sign, shown in signs(samples._replace(finite=finite)).items():
            self.signs[sign][:, times] = shown
        for kind, kept in self._tables.items():
            for name, values in getattr(samples, kind).items():
                kept.setdefault(name, np.full(shape, np.nan))[:, times] = values
        self.rests |= {name: np.asarray(x, float)[:, 0] for name, x in samples.rests.items()}
        self.reached = first + count - 1

    def finish(self, run: Progress, ready: Ready) -> None:
        """The state at the end of all outputs."""
        lived = len(self.part.runs)
        self.watches = jax.tree.map(lambda x: np.asarray(x)[:lived], run.seen)
        self.stopped = np.asarray(run.stopped)[:lived]
        self.peaks = {}
        for name, largest in peaks_of(self.part.plan, run).items():
            values = np.asarray(largest, float)[:lived]
            self.peaks |= parts_of(name, ready.model.lines[name], values, nodes=False)
        self.displacement = {k: np.asarray(x)[:lived] for k, x in run.y.displacement.items()}
        self._finished = True

    def noted(self) -> dict[str, NDArray[Any]]:
        """What has been added, by name, to go on from in another process."""
        found: dict[str, NDArray[Any]] = {"reached": np.asarray(self.reached)}
        found |= {f"signs/{sign.name}": shown for sign, shown in self.signs.items()}
        found |= {f"rests/{name}": values for name, values in self.rests.items()}
        return found | {f"{k}/{name}": v for k, t in self._tables.items() for name, v in t.items()}

    def restore(self, noted: Mapping[str, NDArray[Any]]) -> None:
        """Take what another process has noted."""
        self.reached = int(noted["reached"])
        for sign, shown in self.signs.items():
            shown[...] = noted[f"signs/{sign.name}"]
        for path, values in noted.items():
            kind, _, name = path.partition("/")
            if kind == "rests":
                self.rests[name] = values
            elif kind in self._tables:
                self._tables[kind][name] = values

    def start_positions(self, ready: Ready) -> dict[str, NDArray[np.float64]]:
        """Positions (runs, 3, nodes) of every line at the start (m)."""
        lived = len(self.part.runs)
        if self._start is None:
            self._start = {}
            for name, line in ready.model.lines.items():
                places = np.asarray(line.reference, float)
                places = self.coordinates.expand(places, 1, place=True)
                found = parts_of(name, line, places, nodes=True)
                self._start |= {part: values[:lived] for part, values in found.items()}
        return self._start


def statuses(
    account: Account, converged: NDArray[np.bool_], times: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The first thing that went wrong in each run, and when (s); both of shape (runs,)."""
    status = np.full(len(converged), int(Status.OK))
    first = np.full(len(converged), len(times))
    for sign in SIGNS:
        flag = account.signs[sign][:, : account.reached + 1]
        begins = np.where(flag.any(axis=1), flag.argmax(axis=1), len(times))
        status = np.where(begins < first, int(sign), status)
        first = np.minimum(begins, first)
    when = np.append(times, np.nan)[first]
    status = np.where(converged, status, int(Status.STATICS_NOT_CONVERGED))
    return status, np.where(converged, when, 0.0)


class Balance:
    """How energy went: residual (runs, times) in J, its largest share of the released energy, that.

    residual = stored - stored at the start - work + losses; all NaN where nothing is known.
    """

    def __init__(self, runs: int, times: int):
        self.residual = np.full((runs, times), np.nan)
        self.closure = np.full(runs, np.nan)
        self.released = np.full(runs, np.nan)
        self.opened = np.zeros((runs, times), bool)


def balance(
    account: Account, status: NDArray[np.int64], when: NDArray[np.float64],
    times: NDArray[np.float64],
    starts: Mapping[str, NDArray[np.float64]] = MappingProxyType({}),
) -> Balance:  # fmt: skip
    """The energy account of every run, up to where it went wrong; `starts` (s) of its breaks."""
    found = Balance(len(status), len(times))
    if not account.energy:
        return found
    zero = np.zeros((len(status), len(times)))
    work, lost, stored = zero, zero, zero
    for name, table in account.energy.items():
        if name.startswith("work_"):
            work = work + table
        elif name.startswith("lost_"):
            lost = lost + table
        else:
            stored = stored + table
    rest = status != Status.STATICS_NOT_CONVERGED
    with np.errstate(invalid="ignore", over="ignore"):  # a run that blew up has such energies
        residual = stored - stored[:, :1] - work + lost
        # what thrusters, winches and a current have put in was released as well
        given = sum((np.minimum(account.energy.get(name, zero), 0.0) for name in GIVERS), zero)
        moved = account.energy["kinetic"] + lost - given
        usable = np.isfinite(residual) & ~(times >= when[:, None])
        usable[:, 0] = True
        released = np.nanmax(np.where(usable, moved, 0.0), axis=1)
        worst = np.nanmax(np.where(usable, np.abs(residual), 0.0), axis=1)
        # what has not moved has released rounding alone, which nothing can be a share of
        moving = released > _told(account)
        closure = np.divide(worst, released, out=np.zeros_like(worst), where=moving)
        tolerated = np.maximum(
            ENERGY_LIMIT * released[:, None], _tolerated(account, times, starts.values())
        )
        opened = usable & (np.abs(residual) > tolerated)
    found.residual[rest] = residual[rest]
    found.closure[rest], found.released[rest] = closure[rest], released[rest]
    found.opened[rest] = opened[rest]
    return found


def _tolerated(
    account: Account, times: NDArray[np.float64], starts: Iterable[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Energy (J) that each run may leave open, however little it has released, (runs, times).

    A hundredth of the strain energy that it starts with, or has when one of its breaks begins, so that
    the first steps of a break are no alarm; and what rounding can do, which is all that a line at rest
    has.
    """
    rounding = _rounding(account)[:, None]
    strain = account.energy.get("strain")
    if strain is None:
        return rounding
    held = np.broadcast_to(strain[:, :1], strain.shape)
    for start in starts:
        last = np.clip(np.searchsorted(times, start, side="right") - 1, 0, len(times) - 1)
        there = np.take_along_axis(strain, last[:, None], axis=1)
        held = np.where(times >= start[:, None], np.fmax(held, there), held)
    return np.maximum(0.01 * held, rounding)


def _rounding(account: Account) -> NDArray[np.float64]:
    """What rounding can do to the energy account of each run (J).

    An energy is told to some digits of its size, which for weights goes by how high they are. What is
    summed up step by step, which is as much as energies change, loses half a digit at every step, by
    chance up or down. A share `AT_REST` of the largest energy is nothing in either precision.
    """
    eps = float(np.finfo(account.part.plan.dtype).eps)
    steps = max(account.part.steps, 1) * account.count
    changes = _peaks({n: t - t[:, :1] for n, t in account.energy.items()})
    size = _peaks(account.energy)
    return np.maximum(_told(account), eps * (DIGITS * size + 10.0 * steps**0.5 * changes))


def _told(account: Account) -> NDArray[np.float64]:
    """How finely the energies of each run are told at all (J)."""
    eps = float(np.finfo(account.part.plan.dtype).eps)
    return max(AT_REST, DIGITS * eps) * _peaks(account.energy)


def _peaks(tables: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """The largest size of any energy (runs, times) of each run (J)."""
    sizes = [np.nanmax(np.abs(table), axis=1, initial=0.0) for table in tables.values()]
    return np.nanmax(sizes, axis=0)
