"""How a scene's lines are cut and joined: the part of a model that is structure, not number.

A line that breaks along its length is two pieces joined until then, or, where the place of the break is
to be a number like any other, one piece with a seam. Everything here is plain Python over a concrete
scene; equal layouts (and equal skeletons of the scene) share one compiled program.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import WinchEnd
from lumpedcable.scene.lines import HeldEnd, HeldForce, tie_of

__all__ = [
    "LEAST",
    "Joint",
    "Layout",
    "Piece",
    "cut_keys",
    "cuts_of",
    "layouts_of",
    "make_layout",
    "part_names",
]


LEAST = 2  # segments on either side of a seam: an end's tension is carried on from its last two
IN_SEAM = -1  # in the place of the segments before a cut, where these are a number
LENGTH_KEYS = ("length", "payout.speed", "payout.time")
"""Numbers of a line that its unstretched length follows from."""


@dataclass(frozen=True)
class Piece:
    """One line of the model: `segments` of the scene's line `line` from its segment `first` on.

    `starts_at` and `ends_at` name the event that breaks the line there, None at the line's own ends.
    `seam` is the event that breaks it at a place that is a number, None where there is none.
    """

    name: str
    line: str
    first: int
    segments: int
    starts_at: str | None
    ends_at: str | None
    seam: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What it is called in results: itself, or its parts before and after the seam."""
        return (self.name,) if self.seam is None else part_names(self.name)


@dataclass(frozen=True)
class Joint:
    """Ends of pieces that share a node, ("piece", its end), and the point body at it, if any.

    `held` says that a place, a path or a rigid body holds the node too, `pulled` that a force does.
    """

    members: tuple[tuple[str, int], ...]
    body: str | None
    held: bool
    pulled: bool

    @property
    def parts(self) -> bool:
        """Whether two ends hold each other there and nothing else does: where one goes, both do."""
        alone = self.body is None and not self.held and not self.pulled
        return alone and len(self.members) == 2


@dataclass(frozen=True)
class Layout:
    """All pieces and joints of a scene, and which event breaks which end."""

    pieces: tuple[Piece, ...]
    joints: tuple[Joint, ...]
    breaks: tuple[tuple[str, int, str], ...]

    def of_line(self, line: str) -> tuple[Piece, ...]:
        """The pieces of one of the scene's lines, from its start to its end."""
        return tuple(piece for piece in self.pieces if piece.line == line)

    def joint_of(self, piece: str, node: int) -> int | None:
        """Index of the joint at an end, None where there is none."""
        for index, joint in enumerate(self.joints):
            if (piece, node) in joint.members:
                return index
        return None

    def cuts(self, joint: Joint) -> bool:
        """Whether a joint only cuts one of the scene's lines: nothing else meets there."""
        ends = {
            (piece.line, piece.ends_at if node else piece.starts_at)
            for piece in self.pieces
            for name, node in joint.members
            if piece.name == name
        }
        # the two sides of a break within a line are broken by the same event; others by none
        (_, event), *others = ends
        return event is not None and not others and len(joint.members) == 2

    @property
    def seams(self) -> tuple[Piece, ...]:
        """The pieces that are open at a seam."""
        open_ = {name for joint in self.joints for name, end in joint.members if end in AT_CUT}
        return tuple(piece for piece in self.pieces if piece.name in open_)

    @property
    def whole(self) -> "Layout":
        """The same with its seams closed, as at rest: there no piece has ends."""
        joints = tuple(j for j in self.joints if not any(end in AT_CUT for _, end in j.members))
        breaks = tuple(b for b in self.breaks if b[1] not in AT_CUT)
        return Layout(self.pieces, joints, breaks)

    def event_at(self, piece: str, node: int) -> str | None:
        """Name of the event that breaks an end, None where none does."""
        for name, end, event in self.breaks:
            if (name, end) == (piece, node):
                return event
        return None


AT_CUT = (BEFORE, AFTER)


def part_names(line: str) -> tuple[str, str]:
    """The names of a line's two parts before and after its one cut."""
    return f"{line}-1", f"{line}-2"


def has_seam(scene: Scene, name: str) -> bool:
    """Whether the one place along a line at which it breaks may be a number of the program.

    Not where bending or friction on the bed reaches across it, where winches, trolleys or targets ask
    for the whole line, or where segments differ.
    """
    line = scene.lines[name]
    targets = [event.target() for event in scene.events.values() if event.target()[0] == name]
    if len(targets) != 1 or targets[0][1] is not None:
        return False
    equal = line.segment_lengths is None and line.grading is None
    rigid = scene.materials[line.material].law == "inextensible"
    grips = scene.seabed is not None and scene.seabed.friction is not None
    winches = any(isinstance(end, WinchEnd) for end in (line.start, line.end))
    carries = not all(isinstance(body, Body) for body in scene.bodies.values())
    odd = rigid or grips or winches or carries or line.bending is not None
    odd = odd or bool(scene.targets) or scene.output.static
    return equal and not odd


def _seam_cut(scene: Scene, name: str, cut: ArrayLike) -> NDArray[np.bool_]:
    """Whether cuts with so many segments before them are seams."""
    cut, count = np.asarray(cut), _segments(scene.lines[name])
    return has_seam(scene, name) & (cut >= LEAST) & (cut <= count - LEAST)


def _segments(line) -> int:
    return len(line.segment_lengths) if line.segment_lengths is not None else line.segments


def _cut(line, place: float) -> int:
    """Number of segments before a break at `place` (m), at least one on either side."""
    lengths = None if line.segment_lengths is None else np.asarray(line.segment_lengths)[:, None]
    return int(
        _cuts(_segments(line), np.array([place]), line.unstretched, line.grading, lengths)[0]
    )


def _cuts(count: int, place, length, grading, lengths) -> NDArray[np.int64]:
    """Segments before breaks at the node nearest to each `place` (m), shape (runs,).

    Lengths (m) and grading are numbers or of shape (runs,), `lengths` of segments (segment, runs).
    """
    if count < 2:
        return np.full(place.shape, 1)
    inner = np.arange(1, count)[:, None]
    if lengths is not None:
        ends = np.cumsum(lengths, axis=0)[:-1]
    elif grading is not None and not np.all(np.asarray(grading) == 1.0):
        uneven = np.where(np.asarray(grading) == 1.0, 2.0, grading)
        ratio = uneven ** (1.0 / (count - 1))
        ends = (ratio**inner - 1.0) / (ratio**count - 1.0) * length
        ends = np.where(np.asarray(grading) == 1.0, inner * length / count, ends)
    else:
        return np.clip(np.rint(count * place / length), 1, count - 1).astype(int)
    return 1 + np.argmin(np.abs(ends - place), axis=0)


def cut_keys(scene: Scene) -> set[str]:
    """The numbers of a scene that decide where its lines are cut, by key."""
    keys: set[str] = set()
    for event, own in scene.events.items():
        name, side, _ = own.target()
        if side is None:
            keys.add(f"events.{event}.place")
            keys |= {f"lines.{name}.{key}" for key in LENGTH_KEYS} | {f"lines.{name}.grading"}
            sizes = scene.lines[name].segment_lengths or ()
            keys |= {f"lines.{name}.segment_lengths.{i}" for i in range(len(sizes))}
    return keys


def layouts_of(
    scene: Scene, numbers: Mapping[str, NDArray[np.float64]], runs: int
) -> NDArray[np.int64]:
    """What tells the layouts of `runs` runs apart, shape (runs, breaks along lines).

    Runs of one skeleton and equal rows have equal layouts: `cuts_of`, but for seams.
    """
    cuts = cuts_of(scene, numbers, runs)
    along = [event.target()[0] for event in scene.events.values() if event.target()[1] is None]
    for column, name in enumerate(along):
        mine = cuts[:, column]
        cuts[:, column] = np.where(_seam_cut(scene, name, mine), IN_SEAM, mine)
    return cuts


def cuts_of(
    scene: Scene, numbers: Mapping[str, NDArray[np.float64]], runs: int
) -> NDArray[np.int64]:
    """Where breaks along lines cut them in `runs` runs, shape (runs, breaks): segments before.

    `numbers` are those that differ from the scene's, each of shape (runs,).
    """
    found = []
    for event, own in scene.events.items():
        name, side, place = own.target()
        if side is not None:
            continue
        line, key = scene.lines[name], f"lines.{name}"
        places = np.broadcast_to(numbers.get(f"events.{event}.place", np.asarray(place)), runs)
        lengths = None
        if line.segment_lengths is not None:
            own_lengths = enumerate(line.segment_lengths)
            rows = [
                numbers.get(f"{key}.segment_lengths.{i}", np.asarray(v)) for i, v in own_lengths
            ]
            lengths = np.array([np.broadcast_to(row, runs) for row in rows])
        length = numbers.get(f"{key}.length", line.length)
        if line.payout is not None:
            speed = numbers.get(f"{key}.payout.speed", line.payout.speed)
            length = length + speed * numbers.get(f"{key}.payout.time", line.payout.time)
        grading = numbers.get(f"{key}.grading", line.grading)
        found.append(_cuts(_segments(line), places, length, grading, lengths))
    return np.array(found, int).reshape(len(found), runs).T


def make_layout(scene: Scene, seams: bool = False) -> Layout:
    """The layout of a scene, with `seams` where lines can have them.

    Raises ValueError where a line of one segment is to break along its length, where two breaks fall
    on one node, where every end at a joint or body is to break away from it, or where more than two
    ends of inextensible lines meet.
    """
    pieces: list[Piece] = []
    links: list[set] = []
    breaks: list[tuple[str, int, str]] = []
    outer: dict[str, tuple[str, int]] = {}
    for name, line in scene.lines.items():
        if line.model == "ideal":
            continue  # it has no nodes
        inside = []
        for event_name, event in scene.events.items():
            target, side, place = event.target()
            if target == name and side is None:
                assert place is not None
                inside.append((place, event_name))
        inside.sort()
        cuts = [0, *(_cut(line, place) for place, _ in inside), _segments(line)]
        if any(b <= a for a, b in pairwise(cuts)):
            pairs = zip(pairwise(inside), pairwise(cuts[1:-1]), strict=True)
            same = [f'"{a[1]}" and "{b[1]}"' for (a, b), (i, j) in pairs if i >= j]
            why = f", and {same[0]} break it at one node" if same else ""
            raise ValueError(
                f'line "{name}" has too few segments for its breaks along its length: '
                f"{_segments(line)} segments, {len(inside)} breaks{why}"
            )
        if seams and len(inside) == 1 and bool(_seam_cut(scene, name, cuts[1])):
            event = inside[0][1]
            pieces.append(Piece(name, name, 0, cuts[-1], None, None, event))
            links.append({(name, BEFORE), (name, AFTER)})
            breaks.append((name, BEFORE, event))
            outer[f"{name}.start"], outer[f"{name}.end"] = (name, 0), (name, -1)
            continue
        marks = [None, *(event for _, event in inside), None]
        for k in range(len(cuts) - 1):
            piece = Piece(
                name if not inside else f"{name}-{k + 1}",
                name, cuts[k], cuts[k + 1] - cuts[k], marks[k], marks[k + 1],
            )  # fmt: skip
            if marks[k] is not None:
                links.append({(pieces[-1].name, -1), (piece.name, 0)})
                breaks.append((pieces[-1].name, -1, marks[k]))
            pieces.append(piece)
        own = [piece for piece in pieces if piece.line == name]
        outer[f"{name}.start"] = (own[0].name, 0)
        outer[f"{name}.end"] = (own[-1].name, -1)
    points = {
        name for name, body in scene.bodies.items() if isinstance(body, Body) and not body.rigid
    }
    bodies: dict[str, set] = {name: {("", name)} for name in points}
    links += bodies.values()
    for name, line in scene.lines.items():
        if line.model == "ideal":
            continue
        for side, end in (("start", line.start), ("end", line.end)):
            tie = tie_of(end)
            if tie is not None and not scene.on_body(end):
                mine = outer[f"{name}.{side}"]
                other = ("", tie) if tie in scene.bodies else outer[tie]
                links.append({mine, other})
    for event_name, event in scene.events.items():
        target, side, _ = event.target()
        if side is not None:
            piece, node = outer[f"{target}.{side}"]
            breaks.append((piece, node, event_name))
    held = {outer[end] for end in outer if _holds(scene, end)}
    pulled = {outer[end] for end in outer if _pulls(scene, end)}
    joints = _joints(links, held, pulled)
    layout = Layout(tuple(pieces), tuple(joints), tuple(breaks))
    _refuse_branches(scene, layout)
    for joint in layout.joints:
        leaving = [m for m in joint.members if layout.event_at(*m) is not None]
        if len(leaving) == len(joint.members) and not held & set(leaving):
            where = "a joint" if joint.body is None else f'body "{joint.body}"'
            ends = ", ".join(f"{piece}.{'end' if node else 'start'}" for piece, node in leaving)
            raise ValueError(
                f"expected an end at {where} that does not break away from it, found events that "
                f"break all of them: {ends}"
            )
    return layout


def _refuse_branches(scene: Scene, layout: Layout) -> None:
    """ValueError where lines whose tensions are found along a path branch out."""
    laws = {scene.materials[line.material].law for line in scene.lines.values()}
    if "inextensible" not in laws:
        return
    met = [
        [f"{piece}.{'end' if node else 'start'}" for piece, node in j.members]
        for j in layout.joints
    ]
    for body in scene.bodies:
        ends = [(f"{n}.{side}", getattr(line, side)) for n, line in scene.lines.items()
                for side in ("start", "end")]  # fmt: skip
        met.append([name for name, end in ends if (scene.body_point(end) or ("",))[0] == body])
    for ends in met:
        if len(ends) > 2:
            raise ValueError(
                "expected at most two ends of inextensible lines at one place or body, found "
                + ", ".join(ends)
            )


def _holds(scene: Scene, name: str) -> bool:
    """Whether an end, "LINE.start" or "LINE.end", is held by a place, a path or a rigid body."""
    end = _end_of(scene, name)
    free = end == "free" or tie_of(end) is not None
    return scene.on_body(end) or not (free or _pulls(scene, name))


def _pulls(scene: Scene, name: str) -> bool:
    """Whether an end, "LINE.start" or "LINE.end", is held by a force."""
    end = _end_of(scene, name)
    return isinstance(end, HeldEnd) and isinstance(end.held, HeldForce)


def _end_of(scene: Scene, name: str):
    """What the scene says of an end, "LINE.start" or "LINE.end"."""
    line, _, side = name.rpartition(".")
    return getattr(scene.lines[line], side)


def _joints(links: list[set], held: set, pulled: set) -> list[Joint]:
    groups: list[set] = []
    for link in links:
        touching = [g for g in groups if g & link]
        groups = [g for g in groups if not g & link] + [set().union(link, *touching)]
    joints = []
    for group in groups:
        bodies = [name for piece, name in group if piece == ""]
        members = tuple(sorted((m for m in group if m[0] != ""), key=str))
        if members:
            body = bodies[0] if bodies else None
            joints.append(Joint(members, body, bool(held & group), bool(pulled & group)))
    return sorted(joints, key=lambda j: str(j.members))
