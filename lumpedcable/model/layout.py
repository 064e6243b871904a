"""How a scene's lines are cut and joined: the part of a model that is structure, not number.

A line that breaks along its length is two pieces joined until then, or, where the place of the break is
to be a number like any other, one piece with a seam. Everything here is plain Python over a concrete
scene; equal layouts (and equal skeletons of the scene) share one compiled program.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

from lumpedcable.model.cuts import cut_at, is_seam
from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import held_force, tie_of
from lumpedcable.scene.lines import Line

__all__ = ["Joint", "Layout", "Piece", "layout_of", "make_layout", "part_names"]

End = tuple[str, int]
"""An end of a piece: its name, and which."""


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

    def ends_of(self, line: str) -> tuple[End, End]:
        """The ends of pieces that are the start and the end of one of the scene's lines."""
        pieces = self.of_line(line)
        return (pieces[0].name, 0), (pieces[-1].name, -1)

    def end_of(self, line: str, side: str) -> End:
        """The end of a piece that is the "start" or "end" of one of the scene's lines."""
        return self.ends_of(line)[0 if side == "start" else 1]

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


def make_layout(scene: Scene, seams: bool = False) -> Layout:
    """The layout of a scene, with `seams` where lines can have them.

    Raises ValueError where a line of one segment is to break along its length, where two breaks fall
    on one node, where every end at a joint or body is to break away from it, or where more than two
    ends of inextensible lines meet.
    """
    parts = _Parts()
    for name, line in scene.lines.items():
        if line.model != "ideal":  # it has no nodes
            _cut_up(scene, name, line, seams, parts)
    outer = parts.outer
    for event_name, event in scene.events.items():
        target, side, _ = event.target()
        if side is not None:
            parts.breaks.append((*outer[f"{target}.{side}"], event_name))
    held = {outer[end] for end in outer if _holds(scene, end)}
    pulled = {outer[end] for end in outer if _pulls(scene, end)}
    joints = _joints(parts.links + _ties(scene, outer), held, pulled)
    layout = Layout(tuple(parts.pieces), tuple(joints), tuple(parts.breaks))
    _refuse_branches(scene, layout)
    _refuse_loose(layout, held)
    return layout


def layout_of(study: Study, scene: Scene) -> Layout:
    """The layout of a scene of a study.

    Raises SceneError, with the line of its file, where `make_layout` raises ValueError.
    """
    try:
        return make_layout(scene)
    except ValueError as error:
        raise SceneError([study.fault("lines", str(error))]) from None


@dataclass
class _Parts:
    """What lines are cut into: pieces, ends of them that share a node, breaks, and where the ends of
    the scene's lines ("LINE.start") are.
    """

    pieces: list[Piece] = field(default_factory=list)
    links: list[set] = field(default_factory=list)
    breaks: list[tuple[str, int, str]] = field(default_factory=list)
    outer: dict[str, End] = field(default_factory=dict)


def _cut_up(scene: Scene, name: str, line: Line, seams: bool, parts: _Parts) -> None:
    """Add a line to the parts, in as many pieces as the breaks along it make of it.

    Raises ValueError where it has too few segments for them.
    """
    inside = []
    for event_name, event in scene.events.items():
        target, side, place = event.target()
        if target == name and side is None:
            assert place is not None
            inside.append((place, event_name))
    inside.sort()
    cuts = [0, *(cut_at(line, place) for place, _ in inside), line.count]
    if any(b <= a for a, b in pairwise(cuts)):
        pairs = zip(pairwise(inside), pairwise(cuts[1:-1]), strict=True)
        same = [f'"{a[1]}" and "{b[1]}"' for (a, b), (i, j) in pairs if i >= j]
        why = f", and {same[0]} break it at one node" if same else ""
        raise ValueError(
            f'line "{name}" has too few segments for its breaks along its length: '
            f"{line.count} segments, {len(inside)} breaks{why}"
        )
    if seams and len(inside) == 1 and bool(is_seam(scene, name, cuts[1])):
        event = inside[0][1]
        parts.pieces.append(Piece(name, name, 0, cuts[-1], None, None, event))
        parts.links.append({(name, BEFORE), (name, AFTER)})
        parts.breaks.append((name, BEFORE, event))
        parts.outer |= {f"{name}.start": (name, 0), f"{name}.end": (name, -1)}
        return
    marks = [None, *(event for _, event in inside), None]
    names = [f"{name}-{k + 1}" for k in range(len(cuts) - 1)] if inside else [name]
    for k, own in enumerate(names):
        first, last = cuts[k], cuts[k + 1]
        parts.pieces.append(Piece(own, name, first, last - first, marks[k], marks[k + 1]))
        event = marks[k]
        if event is not None:
            parts.links.append({(names[k - 1], -1), (own, 0)})
            parts.breaks.append((names[k - 1], -1, event))
    parts.outer |= {f"{name}.start": (names[0], 0), f"{name}.end": (names[-1], -1)}


def _ties(scene: Scene, outer: dict[str, End]) -> list[set]:
    """The ends of lines that are tied to each other or to point bodies, ("", its name)."""
    points = [
        name for name, body in scene.bodies.items() if isinstance(body, Body) and not body.rigid
    ]
    links: list[set] = [{("", name)} for name in points]
    for name, line in scene.lines.items():
        if line.model == "ideal":
            continue
        for side, end in (("start", line.start), ("end", line.end)):
            tie = tie_of(end)
            if tie is not None and not scene.on_body(end):
                other = ("", tie) if tie in scene.bodies else outer[tie]
                links.append({outer[f"{name}.{side}"], other})
    return links


def _refuse_loose(layout: Layout, held: set[End]) -> None:
    """ValueError where every end at a joint is to break away from it."""
    for joint in layout.joints:
        leaving = [m for m in joint.members if layout.event_at(*m) is not None]
        if len(leaving) == len(joint.members) and not held & set(leaving):
            where = "a joint" if joint.body is None else f'body "{joint.body}"'
            ends = ", ".join(f"{piece}.{'end' if node else 'start'}" for piece, node in leaving)
            raise ValueError(
                f"expected an end at {where} that does not break away from it, found events that "
                f"break all of them: {ends}"
            )


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
    held = {f"{piece}.{'end' if node else 'start'}" for j in layout.joints if j.held
            for piece, node in j.members}  # fmt: skip
    _refuse_loops([ends for ends in met if not held & {*ends}], [p.name for p in layout.pieces])


def _refuse_loops(met: list[list[str]], names: Iterable[str]) -> None:
    """ValueError where lines lead back to themselves, of ends that meet two by two."""
    beside = {a: b for pair in met if len(pair) == 2 for a, b in (pair, pair[::-1])}
    for name in names:
        loop, here = [name], f"{name}.end"
        while (next_ := beside.get(here)) is not None:
            line, side = next_.rsplit(".", 1)
            if line == name:
                raise ValueError(
                    f"expected inextensible lines that end somewhere, found a loop of {', '.join(loop)}"
                )
            loop.append(line)
            here = f"{line}.{'end' if side == 'start' else 'start'}"


def _holds(scene: Scene, name: str) -> bool:
    """Whether an end, "LINE.start" or "LINE.end", is held by a place, a path or a rigid body."""
    end = _end_of(scene, name)
    free = end == "free" or tie_of(end) is not None
    return scene.on_body(end) or not (free or _pulls(scene, name))


def _pulls(scene: Scene, name: str) -> bool:
    """Whether an end, "LINE.start" or "LINE.end", is held by a force."""
    return held_force(_end_of(scene, name)) is not None


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
