"""What the results of a scene at rest tell of its cables: their numbers, and those in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.line import Line
from lumpedcable.results import ResultWriter, Variable
from lumpedcable.results.chord import along_chord
from lumpedcable.scene import Scene
from lumpedcable.solve.targets import sag_of
from lumpedcable.study.cables import Cable, cables
from lumpedcable.study.prescribed import MODELS, Prescribed, models_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.compiled import Ready

__all__ = ["first_pull", "rest_variables", "write_rest"]

Numbers = dict[str, "NDArray[np.float64]"]


def rest_variables(scene: Scene) -> list[Variable]:
    """Datasets of a scene's cables, one number a run each."""
    found = []
    for cable in cables(scene):
        for key, (unit, text) in cable.numbers.items():
            found.append(Variable(f"rest/{cable.name}/{key}", ("run",), "f8", unit, text))
        for model in models_of(scene, cable):
            for key, (unit, text) in cable.numbers.items():
                path, holds = f"rest/{cable.name}/{model}_{key}", {"holds": MODELS[model]}
                found.append(Variable(path, ("run",), "f8", unit, text, holds))
    return found


def write_rest(
    writer: ResultWriter,
    scenes: Sequence[Scene],
    rows: Sequence[int] | NDArray[np.int64],
    coordinates: Coordinates,
    ready: Ready,
    nodes: Mapping[str, NDArray[np.float64]],
    ends: Mapping[str, NDArray[np.float64]],
) -> None:
    """Write the numbers of all cables of some runs of one structure.

    Args:
        writer: the file; `rest_variables` are declared in it.
        scenes: these runs.
        rows: their rows in the file.
        coordinates: those of the computation.
        ready: these runs at rest.
        nodes: positions (m) of the lines' nodes, each (runs, 3, nodes).
        ends: tensions (N) at the lines' two ends, each (runs, 1, 2).
    """
    good = np.asarray(ready.converged)
    for cable in cables(scenes[0]):
        for key, values in _numbers(scenes, cable, coordinates, ready, nodes, ends).items():
            values = np.where(good, values, np.nan)
            for k, row in enumerate(rows):
                writer.write(f"rest/{cable.name}/{key}", values[k : k + 1], run=slice(row, row + 1))


def first_pull(line: Line) -> Float[Array, " d"]:
    """What the first segment of a line at rest pulls its first node with (N), its shear included."""
    shape = line.shape()
    pull = line.law.tension(shape.strain)[0] * shape.tangent[:, 0]
    return pull if line.bending is None else pull + line.bending.shear(shape)[:, 0]


def _numbers(
    scenes: Sequence[Scene],
    cable: Cable,
    coordinates: Coordinates,
    ready: Ready,
    nodes: Mapping[str, NDArray[np.float64]],
    ends: Mapping[str, NDArray[np.float64]],
) -> Numbers:
    """The numbers of a cable, as computed and by the models that apply, each of shape (runs,)."""
    found = ready.model.lines
    lines = [found[name] for name in cable.lines]
    lengths = [
        np.asarray(line.segment_length).mean(axis=-1) * (nodes[name].shape[-1] - 1)
        for name, line in zip(cable.lines, lines, strict=True)
    ]
    whole = np.concatenate([nodes[name] for name in cable.lines], axis=2)
    from_start = whole - whole[:, :, :1]
    along, height = along_chord(whole), from_start[:, 2]
    pulls = np.asarray(jax.vmap(first_pull)(lines[0]))[:, :, None]
    pull = coordinates.expand(pulls, 1)[:, :, 0]
    found = {
        "length": np.sum(lengths, axis=0),
        "start_tension": ends[cable.lines[0]][:, 0, 0],
        "end_tension": ends[cable.lines[-1]][:, 0, 1],
        "horizontal_tension": np.hypot(pull[:, 0], pull[:, 1]),
    }
    span, rise = along[:, -1], height[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        if len(lines) > 1:
            joint = nodes[cable.lines[0]].shape[2] - 1
            x, z = along[:, joint], height[:, joint]
            found |= {
                "joint_length": lengths[0],
                "joint_x": x,
                "joint_z": z,
                "sag": rise * x / span - z,
            }
        else:
            up = jnp.array([0.0, 0.0, 1.0])
            sags = jax.vmap(lambda line: sag_of(line, up))(jnp.asarray(whole))
            found["sag"] = np.where(span > 0.0, np.asarray(sags), np.nan)
    known = Prescribed(scenes, cable, lengths, span, -rise, found)
    for model in models_of(scenes[0], cable):
        for key, values in known.numbers(model).items():
            found[f"{model}_{key}"] = values
    return {key: np.asarray(values, float) for key, values in found.items()}
