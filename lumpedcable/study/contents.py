"""What a results file holds: its datasets with units, and where each number of a run goes."""

from __future__ import annotations

import importlib.metadata
import json
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lumpedcable import __version__
from lumpedcable.model.assemble import wave_scheme
from lumpedcable.results import (
    FIELD_TIME,
    Coordinate,
    ResultWriter,
    Variable,
    exact_name,
    sweep_coordinates,
)
from lumpedcable.results.schema import PEAK_TENSION
from lumpedcable.scene import CHECKED
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.outcomes import QUANTITIES
from lumpedcable.solve.observe import Sample
from lumpedcable.status import MEANING, Status
from lumpedcable.study.carried import (
    carried_bodies,
    carried_histories,
    carried_variables,
    rider_fields,
)
from lumpedcable.study.energies import energy_terms
from lumpedcable.study.fields import (
    BODY_FIELDS,
    FIELDS,
    TIPS,
    body_fields,
    sized,
    tip_of,
    tip_start,
)
from lumpedcable.study.laying import Laid
from lumpedcable.study.outcome import EXACT, Table, summaries_of
from lumpedcable.study.places import Places, neighbours
from lumpedcable.study.plan import courant_of, fields_of, peaked, recoil_names
from lumpedcable.study.rest import rest_variables
from lumpedcable.study.strength import strength_coordinates

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Contents"]


class Contents:
    """The file of some runs of a study: declared once, filled run by run and time by time.

    What it declares depends on the whole study, so that the files of its parts are alike.
    """

    def __init__(self, laid: Laid, runs: NDArray[np.int64], exact: bool):
        self.laid, self.runs, self.exact = laid, runs, exact
        self.study, self.scene = laid.study, laid.scene
        self.segments = laid.segments
        self.created: str = datetime.now(UTC).isoformat(timespec="seconds")
        layouts = [structure.layout for structure in laid.structures]
        self.ends = list(dict.fromkeys(e for layout in layouts for e in recoil_names(layout)))
        self.fields = fields_of(self.scene)
        self.after = self.scene.output.fields_after
        self.clock = "time" if self.after == 1 else FIELD_TIME  # of the fields
        pieces = [p for s in laid.structures for p in s.layout.pieces]
        self.histories = self.scene.output.keep != "summaries"
        tips = dict.fromkeys(tip_of(end, self.segments) for end in self.ends)
        self.tips = list(tips) if self.histories else []
        self.riders = carried_bodies(self.scene)
        rigid = [n for n, b in self.scene.bodies.items() if isinstance(b, Body) and b.rigid]
        self.bodies = [*rigid, *self.riders] if self.histories else []
        self.places = Places(laid) if self.histories else None
        self.bending = {n for p in pieces for n in p.names if self.scene.lines[p.line].bending}
        laws = {p.name: self.scene.materials[self.scene.lines[p.line].material].law for p in pieces}
        # lines, and parts of lines, of which the largest tensions are kept
        self.peaked = [name for name, law in laws.items() if law == "inextensible"]
        if self.histories and peaked(self.scene):
            self.peaked = list(self.segments)
        kept = self.histories and "energy" in self.scene.output.quantities
        self.energy = energy_terms(laid) if kept else {}

    # --- declaring --------------------------------------------------------------------------

    def open(
        self,
        target: Path,
        parts: Sequence[tuple[str, int]] = (),
        overwrite: bool = True,
        goes_on: bool = False,
        folders: bool = True,
    ) -> ResultWriter:
        """A writer for the file, everything declared; what else is given as to `ResultWriter`.

        Raises OutputError.
        """
        return ResultWriter(
            target,
            dims=self.dims(),
            variables=self.variables(),
            coordinates=self.coordinates(),
            attributes=self.attributes(),
            parts=parts,
            overwrite=overwrite,
            goes_on=goes_on,
            folders=folders,
        )

    def dims(self) -> dict[str, int]:
        """Sizes of all dimensions."""
        dims = {"run": len(self.runs), "time": self.laid.count + 1, "xyz": 3}
        if self.clock != "time":
            dims[self.clock] = self.laid.count // self.after + 1
        for name, segments in self.segments.items():
            dims[f"lines/{name}/segment"] = segments
            dims[f"lines/{name}/node"] = segments + 1
        if self.bodies:
            dims["angle"] = 3
        return dims

    def variables(self) -> list[Variable]:
        """Datasets that are filled while the runs go."""
        codes = {
            "flag_values": [int(s) for s in Status],
            "flag_meanings": " ".join(s.name.lower() for s in Status),
        }
        found = [
            Variable("status", ("run",), "i1", "1", "how the run ended", codes,
                     fill=int(Status.INTERRUPTED)),
            Variable("status_time", ("run",), "f8", "s", "time at which the run went wrong"),
            Variable("status_message", ("run",), "str", "1", "what happened, and advice"),
        ]  # fmt: skip
        precision = "f4" if self.scene.output.precision == "float32" else "f8"
        for name in self.segments:
            for quantity, field in FIELDS.items():
                if quantity in self._fields_of(name):
                    dims = ("run", self.clock, field.of) + (("xyz",) if field.vector else ())
                    path = f"lines/{name}/{quantity}"
                    found.append(Variable(path, dims, precision, field.unit, field.text))
            for side in ("start", "end") if self.histories else ():
                path = f"lines/{name}/{side}_tension"
                text = f"tension at the {side} of the line"
                found.append(Variable(path, ("run", "time"), "f8", "N", text))
        for name, side in self.tips:
            for quantity, (unit, text) in TIPS.items():
                path, dims = f"lines/{name}/{side}_{quantity}", ("run", "time", "xyz")
                found.append(Variable(path, dims, "f8", unit, text.format(side)))
        found += self.places.variables() if self.places else []
        for name in self.peaked:
            path, text = (
                f"lines/{name}/{PEAK_TENSION}",
                "largest tension of each segment at any step",
            )
            found.append(Variable(path, ("run", "segment"), "f8", "N", text))
        for name in self.bodies:
            point = "trolley" if name in self.riders else "centre of gravity"
            for quantity, (last, unit, text) in BODY_FIELDS.items():
                path, dims = f"bodies/{name}/{quantity}", ("run", "time", last)
                found.append(Variable(path, dims, precision, unit, text.format(point)))
        if self.energy:
            for term, text in self.energy.items():
                found.append(Variable(f"energy/{term}", ("run", "time"), "f8", "J", text))
            text = "energy residual: change of stored energy less work plus losses"
            found.append(
                Variable("energy/residual", ("run", "time"), "f8", "J", text, counted=False)
            )
        for end in self.ends:
            for quantity, (unit, text) in QUANTITIES.items():
                found.append(Variable(f"summary/{end}/{quantity}", ("run",), "f8", unit, text))
            for quantity, (unit, text, holds) in EXACT.items() if self.exact else ():
                path = f"summary/{end}/{exact_name(quantity)}"
                found.append(Variable(path, ("run",), "f8", unit, text, {"holds": holds}))
        found += carried_variables(self.scene, self.histories)
        if self.scene.output.static:
            found += rest_variables(self.scene)
        for name, (unit, text) in summaries_of(self.scene).items():
            found.append(Variable(f"summary/{name}", ("run",), "f8", unit, text))
        text = "steps taken, or output times where the solver chooses its steps"
        found.append(Variable("summary/solver_steps", ("run",), "i8", "1", text))
        return found

    def coordinates(self) -> dict[str, Coordinate]:
        """What is known before anything runs: times, swept numbers, node places, references."""
        every = self.scene.output.every
        found = {
            "time": Coordinate(np.arange(self.laid.count + 1) * every, "s", "time"),
            "run": Coordinate(self.runs, "1", "run"),
        }
        if self.clock != "time":
            times = np.arange(self.laid.count // self.after + 1) * (self.after * every)
            found[self.clock] = Coordinate(times, "s", "time of fields")
        runs = self.study.runs
        if runs.axes:
            columns = runs.columns(self.runs)
            swept = [(a.key, a.unit, columns[a.key]) for a in runs.axes]
            found |= sweep_coordinates(swept, self.scene.measures)
        if runs.named:
            names = np.array([runs.name(int(run)) for run in self.runs], object)
            found["case"] = Coordinate(names, "1", "name of the case", ("run",))
        found |= self.places.coordinates(self.runs) if self.places else {}
        if self.histories:
            found |= strength_coordinates(self.study, self.runs, list(self.segments))
        for reference, part in self.scene.references.items():
            for quantity, values in part.values.items():
                if self.ends:
                    unit, text = QUANTITIES.get(quantity, ("1", quantity))
                    path = f"summary/{self.ends[0]}/reference_{reference}_{quantity}"
                    table = np.asarray(values, float)[self.runs]
                    attributes = {"source": part.source}
                    found[path] = Coordinate(table, unit, text, ("run",), attributes)
        return found

    def attributes(self) -> dict[str, Any]:
        """What the file says of itself."""
        scene = self.scene
        return {
            "title": scene.title,
            "scene": self.study.text,
            "scene_path": str(self.study.path),
            "overrides": json.dumps(list(self.study.overrides)),
            "effective_scene": self.study.effective_text,
            "solver": scene.solver.method,
            "courant": courant_of(scene),
            "dtype": scene.solver.dtype,
            "waves": wave_scheme(scene),
            "coordinates": self.laid.coordinates.dimensions,
            "lumpedcable_version": __version__,
            "versions": json.dumps(versions()),
            "created": self.created,
            "events": json.dumps(
                {
                    name: [e.breaks, e.place, e.start, e.time, e.tension]
                    for name, e in scene.events.items()
                }
            ),
        }

    def _fields_of(self, name: str) -> tuple[str, ...]:
        """The fields that are kept of a line, or of a part of one."""
        bends = name in self.bending
        return tuple(q for q in self.fields if bends or q != "bending_moment")

    # --- filling ----------------------------------------------------------------------------

    def mark_impossible(self, runs: NDArray[np.int64], table: Table) -> NDArray[np.bool_]:
        """Which runs can be computed; the others are marked in the table, with their reason.

        The runs of a small sweep were all checked when the file was read.
        """
        right = np.ones(len(runs), bool)
        if len(self.study.runs) <= CHECKED:
            return right
        for run, wrong in self.study.runs.problems(runs).items():
            row = np.flatnonzero(runs == run)
            right[row] = False
            table["status"][row] = int(Status.SCENE_IMPOSSIBLE)
            words = f"{MEANING[Status.SCENE_IMPOSSIBLE]}: {wrong}"
            table["status_message"][row] = words
        return right

    def write(
        self,
        writer: ResultWriter,
        rows: NDArray[np.int64],
        samples: Sample,
        start: dict[str, NDArray[np.float64]],
        first: int,
    ) -> None:
        """Samples (runs, times, ...) from output `first` on, fields of those outputs that have them;
        `start` (runs, 3, nodes) in m.
        """
        if not self.histories:
            return
        for name, fields in samples.fields.items():
            for quantity in (q for q in self._fields_of(name) if q in fields):
                table, field = np.asarray(fields[quantity], float), FIELDS[quantity]
                if field.vector:
                    table = self.laid.coordinates.expand(table, axis=2)
                    if quantity == "position":
                        nodes = self.segments[name] + 1
                        table = sized(table, 3, nodes) + sized(start[name][:, None], 3, nodes)
                    table = np.moveaxis(table, 2, 3)
                size = self.segments[name] + (field.of == "node")
                path, begins = f"lines/{name}/{quantity}", -(-first // self.after)
                self._put(writer, path, rows, begins, sized(table, 2, size), self.clock)
            for k, side in enumerate(("start", "end")):
                ends = np.asarray(samples.ends[name])[:, :, k]
                self._put(writer, f"lines/{name}/{side}_tension", rows, first, ends)
        for end, both in samples.tips.items():
            name, side = tip_of(end, start)
            path = f"lines/{name}/{side}_"
            moved, velocity = np.moveaxis(np.asarray(both, float), 2, 0)
            place = self.laid.coordinates.expand(moved, axis=2)
            place = place + tip_start(start[name], side)[:, None]
            self._put(writer, f"{path}position", rows, first, place)
            velocity = self.laid.coordinates.expand(velocity, axis=2)
            self._put(writer, f"{path}velocity", rows, first, velocity)
        for name in self.bodies:
            q, v = np.moveaxis(np.asarray(samples.bodies[name], float), 2, 0)
            fields = rider_fields if name in self.riders else body_fields
            for quantity, values in fields(self.laid.coordinates, q, v).items():
                self._put(writer, f"bodies/{name}/{quantity}", rows, first, values)
        if self.histories:
            for path, values in carried_histories(self.scene, samples).items():
                self._put(writer, path, rows, first, values)
        for term in samples.energy if self.energy else ():
            self._put(writer, f"energy/{term}", rows, first, np.asarray(samples.energy[term]))

    def _put(
        self, writer: ResultWriter, path: str, rows, first: int, table, clock: str = "time"
    ) -> None:
        if table.shape[1] == 0:
            return
        times = {clock: slice(first, first + table.shape[1])}
        for group in neighbours(rows):
            mine = slice(int(rows[group[0]]), int(rows[group[-1]]) + 1)
            writer.write(path, table[group[0] : group[-1] + 1], run=mine, **times)

    def write_table(self, writer: ResultWriter, first: int, table: Table) -> None:
        """Status and summaries of runs that have ended, from row `first` on."""
        count = len(table["status"])
        for path, values in table.items():
            writer.write(path, values, run=slice(first, first + count))
        for row in np.flatnonzero(table["status"] == int(Status.STATICS_NOT_CONVERGED)):
            self._blank(writer, first + int(row))

    def _blank(self, writer: ResultWriter, row: int) -> None:
        """A run without a start has no history: what was computed from nowhere reads NaN."""
        for variable in self.variables():
            if variable.dims[1:2] in (("time",), (self.clock,)):
                name = variable.path.split("/")[1]
                sizes = self.dims() | {"node": self.segments.get(name, 0) + 1,
                                       "segment": self.segments.get(name, 0)}  # fmt: skip
                shape = (1, *(sizes[d] for d in variable.dims[1:]))
                writer.write(variable.path, np.full(shape, np.nan), run=slice(row, row + 1))


@cache
def versions() -> dict[str, str]:
    """Versions of what computes, by name."""
    names = ("jax", "jaxlib", "diffrax", "equinox", "numpy", "h5py")
    found = {name: importlib.metadata.version(name) for name in names}
    return found | {"python": platform.python_version()}
