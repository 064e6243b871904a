"""Inextensible lines as chains of rods: their masses, forces and directions along a path."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.line import Line
from lumpedcable.model.paths import Path
from lumpedcable.physics.rod import rod_drag, rod_energy

__all__ = [
    "RodEnds",
    "Spread",
    "along_path",
    "forces_along_path",
    "line_drag",
    "line_energy",
    "path_spread",
    "spread_of",
    "to_lines",
    "to_segments",
]


class RodEnds(NamedTuple):
    """Something at the first and the last end of every rod of a path, each (d, n)."""

    first: Float[Array, "d n"]
    last: Float[Array, "d n"]


class Spread(NamedTuple):
    """What rods of a line or a path weigh and resist with, whole rods each, (n,).

    Unstretched lengths (m), masses along and across with added mass (kg), drag factors along and
    across (N s2/m2), zero without drag; by how much a rod lengthens under a force (m/N).
    """

    length: Float[Array, " n"]
    along: Float[Array, " n"]
    across: Float[Array, " n"]
    tangential: Float[Array, " n"]
    normal: Float[Array, " n"]
    give: Float[Array, " n"]


def spread_of(line: Line) -> Spread:
    """The masses and drag factors of a line's segments as rods."""
    length = jnp.broadcast_to(line.segment_length, (line.segments,))
    dry = line.mass * length
    along = across = dry
    if line.added_mass is not None:
        across = dry + line.added_mass.normal * length
        if line.added_mass.tangential is not None:
            along = dry + line.added_mass.tangential * length
    none = jnp.zeros_like(length)
    tangential = none if line.drag is None else line.drag.tangential * length
    normal = none if line.drag is None else line.drag.normal * length
    kept = jnp.broadcast_to(line.kept, (line.segments,))
    give = none if line.give is None else line.give * kept
    return Spread(kept, along, across, tangential, normal, give)


def path_spread(path: Path, lines: dict[str, Line]) -> Spread:
    """The same for all rods of a path, one after the other."""
    parts = [_turned(spread_of(lines[leg.line]), leg.backward) for leg in path.legs]
    return Spread(*(jnp.concatenate(columns) for columns in zip(*parts, strict=True)))


def _turned(tree: Spread, backward: bool) -> Spread:
    return Spread(*(x[::-1] for x in tree)) if backward else tree


def along_path(path: Path, nodal: dict[str, Float[Array, "d nodes"]]) -> RodEnds:
    """Nodal values of lines at the ends of a path's rods."""
    first, last = [], []
    for leg in path.legs:
        x = nodal[leg.line][:, ::-1] if leg.backward else nodal[leg.line]
        first.append(x[:, :-1])
        last.append(x[:, 1:])
    return RodEnds(jnp.concatenate(first, axis=1), jnp.concatenate(last, axis=1))


def forces_along_path(path: Path, nodal: dict[str, Float[Array, "d nodes"]]) -> RodEnds:
    """Nodal forces of lines (N), each once: at the first end of the rod after the node, if any."""
    ends = along_path(path, nodal)
    keep = jnp.zeros(path.places - 1, bool)
    for leg in path.legs:
        keep = keep.at[leg.first + leg.rods - 1].set(True)
    return RodEnds(ends.first, jnp.where(keep, ends.last, 0.0))


def to_lines(path: Path, places: Float[Array, "d places"]) -> dict[str, Float[Array, "d nodes"]]:
    """Values at the places of a path, by line."""
    found = {}
    for leg in path.legs:
        mine = places[:, leg.first : leg.first + leg.rods + 1]
        found[leg.line] = mine[:, ::-1] if leg.backward else mine
    return found


def to_segments(path: Path, rods: Float[Array, " n"]) -> dict[str, Float[Array, " segments"]]:
    """Values of the rods of a path, by line."""
    found = {}
    for leg in path.legs:
        mine = rods[leg.first : leg.first + leg.rods]
        found[leg.line] = mine[::-1] if leg.backward else mine
    return found


def line_energy(
    line: Line, tangent: Float[Array, "d n"], velocity: Float[Array, "d nodes"]
) -> Float[Array, ""]:
    """Kinetic energy (J) of a line of rods."""
    own = spread_of(line)
    return rod_energy(own.along, own.across, tangent, velocity[:, :-1], velocity[:, 1:])


def line_drag(
    line: Line, tangent: Float[Array, "d n"], velocity: Float[Array, "d nodes"],
    flow: Float[Array, "d nodes"] | None,
) -> Float[Array, "d nodes"]:  # fmt: skip
    """Drag of a line of rods on its nodes (N)."""
    own = spread_of(line)
    v = velocity if flow is None else velocity - flow
    first, last = rod_drag(own.normal, own.tangential, tangent, v[:, :-1], v[:, 1:])
    none = jnp.zeros_like(first[:, :1])
    return jnp.concatenate([first, none], axis=1) + jnp.concatenate([none, last], axis=1)
