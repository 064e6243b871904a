"""Lines at rest, cut open where they are to break: from then on both their parts stand in one line."""

import dataclasses
from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int
from numpy.typing import NDArray

from lumpedcable.model.assemble import release_of, seam_of
from lumpedcable.model.ends import Joined, Junction
from lumpedcable.model.layout import Layout, Piece, part_names
from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.physics.seam import EXTRA, Seam
from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.scene import Scene

__all__ = ["at_end", "cut_at", "cuts_in", "opened", "part_length", "part_segments", "parts_of"]


def opened(model: Model, scene: Scene, layout: Layout) -> Model:
    """The model of a layout with seams, from that of its `whole`, which is at rest."""
    lines, cuts, junctions = dict(model.lines), {}, list(model.junctions)
    for piece in layout.seams:
        assert piece.seam is not None
        lines[piece.name] = _opened(model.lines[piece.name], scene, piece)
        joint, release = len(junctions), release_of(scene, piece.seam)
        cuts[piece.name] = (Joined(joint, release), Joined(joint))
        junctions.append(Junction(((piece.name, BEFORE), (piece.name, AFTER))))
    return dataclasses.replace(model, lines=lines, junctions=tuple(junctions), cuts=cuts)


def _opened(line: Line, scene: Scene, piece: Piece) -> Line:
    before, (first, last) = seam_of(scene, piece)
    seam = Seam(before)
    count = piece.segments + EXTRA
    gap, hole = seam.gap(count), seam.hole(count + 1)
    length = jnp.where(jnp.arange(count) < before, first, last)
    own = jnp.where(gap, 0.0, length)
    zero = jnp.zeros(1)
    node_length = 0.5 * (jnp.concatenate([zero, own]) + jnp.concatenate([own, zero]))
    return dataclasses.replace(
        line,
        segment_length=length,
        node_length=jnp.where(hole, 0.0, node_length),
        reference=seam.opened(line.reference),
        # what is no segment has neither direction nor strain
        reference_step=jnp.where(gap, 0.0, seam.widened(line.reference_step)),
        reference_strain=jnp.where(gap, 0.0, seam.widened(line.reference_strain)),
        seam=seam,
    )


def cut_at(model: Model, before: Mapping[str, Int[Array, ""]]) -> Model:
    """The model with so many segments before the seams of some lines, which are their own.

    Where many runs are known to have the same number, what is done at the seam is done side by side.
    """
    if not before:
        return model
    lines = {
        name: dataclasses.replace(line, seam=Seam(before[name])) if name in before else line
        for name, line in model.lines.items()
    }
    return dataclasses.replace(model, lines=lines)


# --- of many runs, outside any program ---------------------------------------------------------------


def cuts_in(model: Model) -> dict[str, NDArray[np.int64]]:
    """By line with a seam, how many segments are before it in each of many runs."""
    seams = {name: line.seam for name, line in model.lines.items()}
    return {name: np.asarray(seam.before) for name, seam in seams.items() if seam is not None}


def parts_of(name: str, line: Line, values: NDArray, nodes: bool) -> dict[str, NDArray]:
    """Values (runs, ..., n) along a line of many runs, by the names of its parts where it is cut.

    Each part is filled up with NaN to the longest of these runs.
    """
    if line.seam is None:
        return {name: values}
    before, count = np.asarray(line.seam.before), values.shape[-1]
    after = before + EXTRA
    sizes = before + nodes, count - after
    found = [np.full((*values.shape[:-1], int(size.max())), np.nan) for size in sizes]
    for run, own in enumerate(values):
        found[0][run, ..., : sizes[0][run]] = own[..., : sizes[0][run]]
        found[1][run, ..., : sizes[1][run]] = own[..., after[run] :]
    return dict(zip(part_names(name), found, strict=True))


def part_length(line: Line, run: int, end: int) -> float:
    """Unstretched length (m) of a line of one of many runs, or of its part with an end at the cut."""
    lengths = np.asarray(line.segment_length)[run]
    count = line.reference.shape[-1] - 1
    if line.seam is None:
        return float(np.sum(np.broadcast_to(lengths, (count,))))
    before = int(np.asarray(line.seam.before)[run])
    first, last = (float(np.sum(part)) for part in (lengths[:before], lengths[before + EXTRA :]))
    return {BEFORE: first, AFTER: last}.get(end, first + last)


def part_segments(line: Line, end: int) -> NDArray[np.int64]:
    """Segments (runs,) of a line of many runs, or of its part with an end at the cut."""
    count = line.reference.shape[-1] - 1
    if line.seam is None:
        return np.full(line.reference.shape[0], count)
    before, whole = np.asarray(line.seam.before), count - EXTRA
    return {BEFORE: before, AFTER: whole - before}.get(end, np.full_like(before, whole))


def at_end(line: Line, values: NDArray, end: int) -> NDArray:
    """Values (runs, ..., nodes or segments) along a line of many runs, at one of its ends."""
    if line.seam is None:
        return values[..., end]
    nodes = values.shape[-1] > line.segment_length.shape[-1]
    place = line.node(end) if nodes else line.segment(end)
    index = np.broadcast_to(np.asarray(place) % values.shape[-1], values.shape[:1])
    index = index.reshape(-1, *(1,) * (values.ndim - 1))
    return np.take_along_axis(values, index, axis=-1)[..., 0]
