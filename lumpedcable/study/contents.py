"""What a results file holds: its datasets with units, and where each number of a run goes."""

from __future__ import annotations

import importlib.metadata
import json
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from lumpedcable import __version__
from lumpedcable.model.assemble import assemble, segment_lengths, wave_scheme
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import body_works
from lumpedcable.model.energy import WORKS, works_of
from lumpedcable.results import Coordinate, ResultWriter, Variable, sweep_coordinates
from lumpedcable.scene import Scene, Study
from lumpedcable.scene.bodies import Body
from lumpedcable.solve.observe import Sample
from lumpedcable.status import Status
from lumpedcable.study.carried import (
    carried_bodies,
    carried_variables,
    payouts,
    rider_fields,
)
from lumpedcable.study.plan import Batch
from lumpedcable.study.summary import EXACT, QUANTITIES, Outcome, recoil_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Contents", "energy_terms"]

FIELDS = {
    "position": ("node", "m", "position"),
    "velocity": ("node", "m/s", "velocity"),
    "tension": ("segment", "N", "tension, damping included"),
    "strain": ("segment", "1", "strain"),
}
BODY_FIELDS = {
    "position": ("xyz", "m", "place of the centre of gravity"),
    "velocity": ("xyz", "m/s", "velocity of the centre of gravity"),
    "attitude": ("angle", "rad", "roll, pitch, yaw"),
    "turning": ("angle", "rad/s", "rates of roll, pitch, yaw"),
}
STORED = {
    "kinetic": "kinetic energy, added mass included",
    "strain": "strain energy",
    "gravitational": "potential energy of weight less buoyancy",
    "bending": "bending energy",
    "seabed": "energy stored in the seabed",
    "winch": "what winches have put into the lines, as if it were stored",
    "contact": "energy stored where trolleys touch their lines",
    "hydrostatic": "energy of hulls that heave, roll or pitch",
}
SUMMARIES = {
    "energy_closure": "largest energy residual over released energy",
    "released_energy": "energy turned into motion or lost",
    "static_imbalance": "largest force left by statics over the largest force",
    "solver_step": "time step",
}
UNITS = {"released_energy": "J", "solver_step": "s"}


def energy_terms(scene: Scene, batch: Batch, coordinates: Coordinates) -> dict[str, str]:
    """Energy datasets of a scene: name to long name, stored ones first."""
    # only names and structure are asked for: nothing is computed
    model = jax.eval_shape(lambda: assemble(scene, batch.structure.layout, coordinates))
    stored = {"kinetic", "strain"}
    kinds: set[str] = set()
    for line in model.lines.values():
        stored |= {load.energy_name for load in line.loads}
        kinds |= set(works_of(line, scene.solver.method == "leapfrog"))
    for name, body in model.bodies.items():
        stored |= set(jax.eval_shape(lambda b: b.stored(b.reference), body))
        kinds |= set(body_works(model, name))
    stored |= {coupled.law.energy_name for coupled in model.couplings}
    if any(junction.load is not None for junction in model.junctions):
        stored.add("gravitational")
    terms = {name: text for name, text in STORED.items() if name in stored}
    for kind, (sign, text) in WORKS.items():
        if kind in kinds:
            terms[f"work_{kind}" if sign > 0 else f"lost_{kind}"] = text
    return terms


class Contents:
    """The file of a study: declared once, filled run by run and time by time."""

    def __init__(
        self,
        study: Study,
        scenes: Sequence[Scene],
        groups: Sequence[Batch],
        coordinates: Coordinates,
        count: int,
    ):
        self.study, self.scenes, self.coordinates, self.count = study, scenes, coordinates, count
        self.scene = scenes[0]
        self.groups = groups
        self.layout_of = {run: b.structure.layout for b in groups for run in b.runs}
        self.segments: dict[str, int] = {}
        for batch in groups:
            for piece in batch.structure.layout.pieces:
                known = self.segments.get(piece.name, 0)
                self.segments[piece.name] = max(known, piece.segments)
        self.ends = list(dict.fromkeys(e for b in groups for e in recoil_names(b.structure.layout)))
        self.bodies = [
            name
            for name, body in self.scene.bodies.items()
            if isinstance(body, Body) and body.rigid
        ]
        self.riders = carried_bodies(self.scene)
        self.bodies += self.riders
        self.energy = energy_terms(self.scene, groups[0], coordinates)
        if "energy" not in self.scene.output.quantities:
            self.energy = {}

    # --- declaring --------------------------------------------------------------------------

    def open(self, target: Path) -> ResultWriter:
        """A writer for the file, everything declared. Raises OutputError."""
        dims = {"run": len(self.scenes), "time": self.count + 1, "xyz": 3}
        for name, segments in self.segments.items():
            dims[f"lines/{name}/segment"] = segments
            dims[f"lines/{name}/node"] = segments + 1
        if self.bodies:
            dims["angle"] = 3
        return ResultWriter(
            target,
            dims=dims,
            variables=self._variables(),
            coordinates=self._coordinates(),
            attributes=self._attributes(),
        )

    def _variables(self) -> list[Variable]:
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
            for quantity, (place, unit, text) in FIELDS.items():
                if quantity in self.scene.output.quantities:
                    dims = ("run", "time", place) + (("xyz",) if place == "node" else ())
                    path = f"lines/{name}/{quantity}"
                    found.append(Variable(path, dims, precision, unit, text))
            for side in ("start", "end"):
                path = f"lines/{name}/{side}_tension"
                text = f"tension at the {side} of the line"
                found.append(Variable(path, ("run", "time"), "f8", "N", text))
        for name in self.bodies:
            for quantity, (last, unit, text) in BODY_FIELDS.items():
                path = f"bodies/{name}/{quantity}"
                found.append(Variable(path, ("run", "time", last), precision, unit, text))
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
            for quantity, (unit, text, holds) in EXACT.items():
                path = f"summary/{end}/exact_{quantity}"
                found.append(Variable(path, ("run",), "f8", unit, text, {"holds": holds}))
        found += carried_variables(self.scene)
        for name, text in SUMMARIES.items():
            path = f"summary/{name}"
            found.append(Variable(path, ("run",), "f8", UNITS.get(name, "1"), text))
        return found

    def _coordinates(self) -> dict[str, Coordinate]:
        every = self.scene.output.every
        found = {
            "time": Coordinate(np.arange(self.count + 1) * every, "s", "time"),
            "run": Coordinate(np.arange(len(self.scenes)), "1", "run"),
        }
        if self.study.axes:
            values = [self.study.runs.values(r) for r in range(len(self.scenes))]  # type: ignore[attr-defined]
            axes = [(a.key, a.unit, [v[a.key] for v in values]) for a in self.study.axes]
            found |= sweep_coordinates(axes)
        for name, segments in self.segments.items():
            nodes = np.full((len(self.scenes), segments + 1), np.nan)
            for run, scene in enumerate(self.scenes):
                places = node_places(scene, self.layout_of[run], name)
                nodes[run, : places.size] = places
            middle = 0.5 * (nodes[:, 1:] + nodes[:, :-1])
            texts = ("unstretched distance from the start of the line", "the same, segment middles")
            for path, dim, table, text in (
                ("unstretched_position", "node", nodes, texts[0]),
                ("unstretched_segment", "segment", middle, texts[1]),
            ):
                same = np.all((table == table[0]) | (np.isnan(table) & np.isnan(table[0])))
                dims = (dim,) if same else ("run", dim)
                values = table[0] if same else table
                found[f"lines/{name}/{path}"] = Coordinate(values, "m", text, dims=dims)
        for reference, part in self.scene.references.items():
            for quantity, values in part.values.items():
                if self.ends:
                    unit, text = QUANTITIES.get(quantity, ("1", quantity))
                    path = f"summary/{self.ends[0]}/reference_{reference}_{quantity}"
                    table = np.asarray(values, float)
                    attributes = {"source": part.source}
                    found[path] = Coordinate(table, unit, text, ("run",), attributes)
        return found

    def _attributes(self) -> dict[str, Any]:
        scene = self.scene
        names = ("jax", "jaxlib", "diffrax", "equinox", "numpy", "h5py")
        versions = {name: importlib.metadata.version(name) for name in names}
        versions["python"] = platform.python_version()
        return {
            "title": scene.title,
            "scene": self.study.text,
            "scene_path": str(self.study.path),
            "overrides": json.dumps(list(self.study.overrides)),
            "effective_scene": self.study.effective_text,
            "solver": scene.solver.method,
            "courant": scene.solver.courant,
            "dtype": scene.solver.dtype,
            "waves": wave_scheme(scene),
            "coordinates": self.coordinates.dimensions,
            "lumpedcable_version": __version__,
            "versions": json.dumps(versions),
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
            "events": json.dumps(
                {name: [e.breaks, e.place, e.start, e.time] for name, e in scene.events.items()}
            ),
        }

    # --- filling ----------------------------------------------------------------------------

    def write(
        self,
        writer: ResultWriter,
        runs: tuple[int, ...],
        samples: Sample,
        start: dict[str, NDArray[np.float64]],
        first: int,
    ) -> None:
        """Samples (runs, times, ...) from output `first` on; `start` (runs, 3, nodes) in m."""
        for name, fields in samples.fields.items():
            for quantity, values in fields.items():
                table = np.asarray(values, float)
                if FIELDS[quantity][0] == "node":
                    table = self.coordinates.expand(table, axis=2)
                    if quantity == "position":
                        table = table + start[name][:, None]
                    table = np.moveaxis(table, 2, 3)
                size = self.segments[name] + (FIELDS[quantity][0] == "node")
                self._put(writer, f"lines/{name}/{quantity}", runs, first, _padded(table, size))
            for k, side in enumerate(("start", "end")):
                ends = np.asarray(samples.ends[name])[:, :, k]
                self._put(writer, f"lines/{name}/{side}_tension", runs, first, ends)
        for name in self.bodies:
            q, v = np.moveaxis(np.asarray(samples.bodies[name], float), 2, 0)
            fields = rider_fields if name in self.riders else body_fields
            for quantity, values in fields(self.coordinates, q, v).items():
                self._put(writer, f"bodies/{name}/{quantity}", runs, first, values)
        for path, values in payouts(self.scene, samples).items():
            self._put(writer, path, runs, first, values)
        for name, values in samples.measures.items():
            self._put(writer, f"measures/{name}", runs, first, np.asarray(values, float))
        for term in samples.energy if self.energy else ():
            self._put(writer, f"energy/{term}", runs, first, np.asarray(samples.energy[term]))

    def _put(self, writer: ResultWriter, path: str, runs: tuple[int, ...], first: int, table):
        times = slice(first, first + table.shape[1])
        if runs == tuple(range(runs[0], runs[0] + len(runs))):
            writer.write(path, table, run=slice(runs[0], runs[0] + len(runs)), time=times)
            return
        for k, run in enumerate(runs):
            writer.write(path, table[k], run=run, time=times)

    def write_outcome(self, writer: ResultWriter, run: int, outcome: Outcome) -> None:
        """Status and summaries of a run that has ended."""
        one = slice(run, run + 1)
        writer.write("status", [int(outcome.status)], run=one)
        writer.write("status_time", [outcome.status_time], run=one)
        writer.write("status_message", [outcome.message], run=one)
        for name in SUMMARIES:
            writer.write(f"summary/{name}", [getattr(outcome, name)], run=one)
        for name, value in outcome.measures.items():
            writer.write(f"summary/{name}", [value], run=one)
        for end, numbers in outcome.recoils.items():
            for quantity, value in numbers.items():
                writer.write(f"summary/{end}/{quantity}", [value], run=one)
        if self.energy:
            writer.write("energy/residual", outcome.residual[None], run=one)
        if outcome.status is Status.STATICS_NOT_CONVERGED:
            self._blank(writer, run)

    def _blank(self, writer: ResultWriter, run: int) -> None:
        """A run without a start has no history: what was computed from nowhere reads NaN."""
        for variable in self._variables():
            if variable.dims[:2] == ("run", "time"):
                name = variable.path.split("/")[1]
                sizes = {"node": self.segments.get(name, 0) + 1,
                         "segment": self.segments.get(name, 0), "xyz": 3, "angle": 3}  # fmt: skip
                shape = (1, self.count + 1, *(sizes[d] for d in variable.dims[2:]))
                writer.write(variable.path, np.full(shape, np.nan), run=slice(run, run + 1))


def body_fields(coordinates: Coordinates, q, v) -> dict[str, NDArray[np.float64]]:
    """Places (m), velocities (m/s), angles (rad) and their rates from q and v (runs, times, m)."""
    d = coordinates.dimensions
    found = {}
    for places, angles, values in (("position", "attitude", q), ("velocity", "turning", v)):
        found[places] = coordinates.expand(values[..., :d], 2, place=places == "position")
        turned = values[..., d:]
        if d == 2:
            turned = turned * np.cross(coordinates.axes[:, 1], coordinates.axes[:, 0])
        found[angles] = turned if d > 1 else np.zeros((*values.shape[:-1], 3))
    return found


def node_places(scene: Scene, layout, name: str) -> NDArray[np.float64]:
    """Unstretched distances (m) of a piece's nodes from the start of the scene's line."""
    piece = next(p for p in layout.pieces if p.name == name)
    lengths = np.broadcast_to(segment_lengths(scene, piece, np), (piece.segments,))
    begin = 0.0
    for other in layout.of_line(piece.line):
        if other.name == name:
            break
        own = np.broadcast_to(segment_lengths(scene, other, np), (other.segments,))
        begin += float(own.sum())
    return begin + np.concatenate([[0.0], np.cumsum(lengths)])


def _padded(table: NDArray[Any], size: int) -> NDArray[Any]:
    """Axis 2 filled up with NaN to `size`, where another run of the study has more nodes."""
    missing = size - table.shape[2]
    if missing == 0:
        return table
    widths = [(0, 0)] * table.ndim
    widths[2] = (0, missing)
    return np.pad(table, widths, constant_values=np.nan)
