"""Breaks that are over before a wave is through a segment, and what is to be said of fits to them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from lumpedcable.model.assemble import segment_lengths
from lumpedcable.model.layout import make_layout
from lumpedcable.model.materials import law_of
from lumpedcable.physics.tension import stiffness_bound
from lumpedcable.scene import Scene
from lumpedcable.scene.units import format_quantity

__all__ = ["coarse_breaks"]

SAFE = 2.0  # times the segments with which a wave takes as long as the break
MOST = 1000  # segments that are advised


class _Coarse(NamedTuple):
    """A break that takes `time` (s), on a line of which a segment takes `travel` (s)."""

    event: str
    line: str
    time: float
    travel: float
    segments: int

    @property
    def enough(self) -> float:
        """Segments with which a wave would be through one within the break."""
        return self.segments * self.travel / self.time if self.time > 0.0 else math.inf


def coarse_breaks(scenes: Iterable[Scene]) -> list[str]:
    """What is to be said of breaks that take less than the l / c of a segment beside them.

    With c the largest wave speed of the law. Such a break moves one node before any other hears of it,
    so that what a record tells of the time between is the mesh's: a sum of squares has several minima
    there, and the intervals about one of them leave the truth out.
    """
    found: dict[tuple[str, str], _Coarse] = {}
    for scene in scenes:
        for one in _coarse(scene):
            key = one.event, one.line
            worst = found.get(key)
            if worst is None or one.travel * worst.time > worst.travel * one.time:
                found[key] = one
    return [_words(one) for one in found.values()]


def _coarse(scene: Scene) -> Iterable[_Coarse]:
    layout = make_layout(scene)
    for name, event in scene.events.items():
        own, side, place = event.target()
        line, pieces = scene.lines[own], layout.of_line(own)
        material = scene.materials[line.material]
        if not pieces or material.law == "inextensible":
            continue
        lengths = np.concatenate(
            [np.broadcast_to(segment_lengths(scene, p, np), (p.segments,)) for p in pieces]
        )
        beside = lengths[{"start": slice(1), "end": slice(-1, None)}[side]] if side else lengths
        if place is not None:
            before = int(np.argmin(np.abs(np.cumsum(lengths)[:-1] - place)))
            beside = lengths[before : before + 2]
        stiff = float(stiffness_bound(law_of(material), jnp.asarray(material.max_strain)))
        travel = float(np.max(beside)) * math.sqrt(line.mass / stiff)
        if event.time < travel:
            yield _Coarse(name, own, event.time, travel, lengths.size)


def _words(one: _Coarse) -> str:
    travel = format_quantity(one.travel, "s", 2)
    where = f'segment of "{one.line}"'
    if one.time == 0.0:
        return (
            f'"{one.event}" breaks at once, and a wave takes {travel} through a {where}: what the data '
            "tell of that time is the mesh's. Give the break the time that it takes."
        )
    time = format_quantity(one.time, "s", 2)
    said = (
        f'"{one.event}" breaks in {time}, and a wave takes {travel} through a {where}: with so coarse '
        "a mesh there can be several best fits, and intervals that leave the truth out."
    )
    if one.enough > MOST:
        return said
    segments = 10 * math.ceil(SAFE * one.enough / 10)
    return f'{said} Take {segments} segments ("lines.{one.line}.segments" in [set]).'
