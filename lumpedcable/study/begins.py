"""When breaks begin in the runs of a study, and whose waves an end may feel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.layout import Layout
from lumpedcable.model.reels import AbstractReel
from lumpedcable.model.seams import part_segments
from lumpedcable.scene import Scene, Study
from lumpedcable.solve.observe import FAR, Recoil
from lumpedcable.study.compiled import Ready
from lumpedcable.study.plan import recoil_event

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.account import Account
    from lumpedcable.study.part import Part

__all__ = ["Starts", "begins_of", "earliest", "other_begins", "source_of", "starts_of"]

Starts = Mapping[str, "NDArray[np.float64]"]


def starts_of(study: Study, part: Part, account: Account) -> Starts:
    """By event, when it begins in each run (s), inf where it never does, shape (runs,)."""
    moved, runs = study.runs.numbers(part.runs), len(part.runs)
    given = {
        name: np.broadcast_to(moved.get(f"events.{name}.start", event.start), runs).astype(float)
        for name, event in part.structure.scene.events.items()
    }
    return given | account.starts


def begins_of(part: Part, starts: Starts, recoil: Recoil) -> NDArray[np.float64]:
    """When the break of a recoiling end begins in each run (s): its own, or its partner's."""
    return starts[recoil_event(part.structure.layout, recoil)]


def other_begins(part: Part, starts: Starts, recoil: Recoil) -> NDArray[np.float64]:
    """When another break whose waves the far end of a recoiling one may feel begins in each run (s).

    Any before its own, of its line or of one that waves reach it from, and what breaks at the far end;
    inf where there is none.
    """
    scene, layout = part.structure.scene, part.structure.layout
    piece = next(piece for piece in layout.pieces if piece.name == recoil.line)
    far = _events_at(layout, piece.name, FAR[recoil.node])
    if recoil.node in (0, -1):
        far.add(piece.seam)  # which lies on the way
    lines = _connected(scene, layout, piece.line)
    begins = begins_of(part, starts, recoil)
    first = np.full(len(part.runs), np.inf)
    for name, event in scene.events.items():
        if event.target()[0] in lines:
            start = starts[name]
            first = np.where((name in far) | (start < begins), np.fmin(first, start), first)
    return first


def _events_at(layout: Layout, piece: str, node: int) -> set[str | None]:
    """The events that an end of a piece feels at once: its own and, where they share it, others'."""
    joint = layout.joint_of(piece, node)
    shared = () if joint is None or layout.joints[joint].held else layout.joints[joint].members
    return {layout.event_at(*member) for member in ((piece, node), *shared)}


def _connected(scene: Scene, layout: Layout, line: str) -> set[str]:
    """The scene's lines that waves come to a line from: over joints and bodies that give way, itself."""
    of = {piece.name: piece.line for piece in layout.pieces}
    groups = [{of[name] for name, _ in joint.members} for joint in layout.joints if not joint.held]
    on_bodies: dict[str, set[str]] = {}
    for name, own in scene.lines.items():
        for end in (own.start, own.end):
            body, _ = scene.body_point(end) or ("", None)
            on_bodies.setdefault(body, set()).add(name)
    on_bodies.pop("", None)  # ends elsewhere
    groups += on_bodies.values()
    found, size = {line}, 0
    while len(found) > size:
        size = len(found)
        found = found.union(*(group for group in groups if group & found))
    return found


def earliest(ready: Ready, recoil: Recoil) -> NDArray[np.float64]:
    """The least time (s) that a break may take to the far end of each of many runs, -inf if unknown.

    inf where a single segment has both ends: the far one reads the tension of what breaks, not a wave.
    From two on there is a node in between which must move first.

    Nothing goes faster than a segment in the largest stable step. Ahead of a front a chain of n
    segments has a foot, an Airy function of the width (n / 8)^(1/3) segments: at 2.8 widths half a per
    cent of the front, which a wall doubles. Two segments more are what reading a tension at an end
    blurs. A line that has no speed of waves, or that is on a winch or drum, has no such bound.
    """
    line, bound = ready.model.lines[recoil.line], np.asarray(ready.bound, float)
    reels = [body for body in ready.model.bodies.values() if isinstance(body, AbstractReel)]
    n = part_segments(line, recoil.node)
    foot = (n - 2.8 * np.cbrt(n / 8.0) - 2.0) * bound
    if line.inextensible or any(reel.line == recoil.line for reel in reels):
        foot = np.full(bound.shape, -np.inf)
    return np.where(n > 1, foot, np.inf)


def source_of(scene: Scene, piece: str) -> str:
    """The scene's line that a piece belongs to: "rope" for "rope" and for "rope-2"."""
    return piece if piece in scene.lines else piece.rpartition("-")[0]
