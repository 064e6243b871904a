"""Largest tensions over the breaking strengths of their materials: how far a run uses its lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.seams import parts_of
from lumpedcable.results import Coordinate
from lumpedcable.results.human import quantity
from lumpedcable.results.schema import BREAKING_STRENGTH
from lumpedcable.scene import Scene, Study
from lumpedcable.study.account import Account
from lumpedcable.study.begins import source_of
from lumpedcable.study.compiled import Ready

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.part import Part

__all__ = ["UTILISATION", "Utilised", "has_strength", "strength_coordinates", "utilised"]

UTILISATION = "utilisation"
"""Name of the largest tension over strength among the numbers of a run."""


def has_strength(scene: Scene) -> bool:
    """Whether a material of some line with nodes has a breaking strength."""
    return any(_strong(scene, name) for name in scene.lines)


def _strong(scene: Scene, line: str) -> bool:
    part = scene.lines[line]
    return part.model == "lumped" and scene.materials[part.material].breaking_strength is not None


def _strengths(study: Study, runs: NDArray[np.int64], line: str) -> NDArray[np.float64]:
    """Breaking strength (N) of a line in some runs, shape (runs,)."""
    material = study.scene.lines[line].material
    own = study.runs.columns(runs).get(f"materials.{material}.breaking_strength")
    told = study.scene.materials[material].breaking_strength if own is None else own
    return np.broadcast_to(np.asarray(told, float), (len(runs),))


def strength_coordinates(
    study: Study, runs: NDArray[np.int64], lines: list[str]
) -> dict[str, Coordinate]:
    """Datasets of the strengths (N) of lines, or parts of lines, that have one, (run,)."""
    text = "breaking strength of the material"
    found = {}
    for name in lines:
        line = source_of(study.scene, name)
        if _strong(study.scene, line):
            values = _strengths(study, runs, line)
            path = f"lines/{name}/{BREAKING_STRENGTH}"
            found[path] = Coordinate(values, "N", text, ("run",))
    return found


class Utilised:
    """Largest tension over strength of each run, and what to say where it exceeds 1.

    Attributes:
        most: the largest of all lines (-), NaN where none is known, shape (runs,).
        words: of each run which line, where and by when; "" where none is beyond its strength.
    """

    def __init__(self, most: NDArray[np.float64], words: list[str]):
        self.most, self.words = most, words


def utilised(
    study: Study, part: Part, ready: Ready, account: Account, good: NDArray[np.bool_],
    sound: NDArray[np.bool_], times: NDArray[np.float64],
) -> Utilised:  # fmt: skip
    """Compare the lines of a part's runs with their strengths, at the output times that are `good`.

    Of `sound` runs the largest tensions of segments, where they are known, say where it was.
    """
    runs = len(part.runs)
    scene, pieces = part.structure.scene, part.structure.layout.pieces
    strong = [piece for piece in pieces if _strong(scene, piece.line)]
    if not strong:
        return Utilised(np.full(runs, np.nan), [""] * runs)
    shares = np.full((len(strong), runs, len(times)), np.nan)
    for k, piece in enumerate(strong):
        tension = account.largest[f"tension of {piece.name}"]
        strength = _strengths(study, part.runs, piece.line)
        shares[k] = np.where(good & np.isfinite(tension), tension, np.nan) / strength[:, None]
    known = np.where(np.isfinite(shares), shares, -np.inf)
    each = known.max(axis=2)
    most = np.where(np.isfinite(each.max(axis=0)), each.max(axis=0), np.nan)
    words = [""] * runs
    for run in np.flatnonzero(most > 1.0):
        piece = strong[int(each[:, run].argmax())]
        row = known[int(each[:, run].argmax()), run]
        strength = float(_strengths(study, part.runs, piece.line)[run])
        borne = most[run] * strength
        place = _place(part, ready, account, piece.line, int(run), borne) if sound[run] else None
        at = "" if place is None else f" at {place:.4g} m"
        when = quantity(float(times[int((row > 1.0).argmax())]), "s", 6)
        lines = {one.line for one, own in zip(strong, each[:, run], strict=True) if own > 1.0}
        others = f", and so are {len(lines) - 1} other lines" if len(lines) > 2 else ""
        others = ", and so is another line" if len(lines) == 2 else others
        words[run] = (
            f'line "{piece.line}" bears {quantity(float(most[run]) * strength, "N", 4)}{at}, '
            f"{most[run]:.3g} times its breaking strength of {quantity(strength, 'N', 4)}: "
            f"beyond it by {when}{others}"
        )
    return Utilised(most, words)


def _place(
    part: Part, ready: Ready, account: Account, line: str, run: int, borne: float
) -> float | None:
    """Unstretched distance (m) from the start of a line of where it bore the most, if that is known.

    It is the middle of a segment, or its end where no segment bore as much as the line, `borne` (N).
    """
    best, place, before, to_end = -np.inf, None, 0.0, 0.0
    for piece in part.structure.layout.of_line(line):
        own = ready.model.lines[piece.name]
        count = np.asarray(own.reference).shape[-1] - 1
        lengths = np.asarray(own.segment_length, float)
        lengths = np.broadcast_to(lengths, (len(lengths), count))
        for name, mine in parts_of(piece.name, own, lengths, nodes=False).items():
            mine = mine[run][np.isfinite(mine[run])]
            peaks = account.peaks.get(name, np.zeros((0, 0)))[run : run + 1, : len(mine)].ravel()
            if peaks.size and np.nanmax(peaks, initial=-np.inf) > best:
                top = int(np.nanargmax(peaks))
                best, place = peaks[top], before + float(mine[:top].sum() + 0.5 * mine[top])
                side = int(top == len(mine) - 1) - int(top == 0)
                to_end = 0.5 * side * float(mine[top])
            before += float(mine.sum())
    return place if place is None or borne <= best * (1.0 + 1e-9) else place + to_end
