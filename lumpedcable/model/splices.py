"""Nodes at which the bending of one line goes on in another.

They are the rigid joints of a scene, and the cuts of lines with bending that are to break along their
length, whose parts bend as one until they do. What bends over such a node belongs to neither line; where
one of them breaks away there, it fades like the force does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.couple import Found
from lumpedcable.model.ends import Release
from lumpedcable.model.evaluation import Splice
from lumpedcable.model.model import LineEnd, Model
from lumpedcable.physics.bending import Side, bent, moment_across, softness
from lumpedcable.physics.load import Shape

__all__ = ["Spliced", "add_splices", "bent_over", "meeting", "moments", "spliced", "splices"]


class Spliced(NamedTuple):
    """Two ends over which lines bend as one, and the breaks that end it."""

    ends: tuple[LineEnd, LineEnd]
    releases: tuple[Release, ...]

    def held(self, t: Float[Array, ""]) -> Float[Array, ""]:
        """The share (-) of the bending that is left at t (s)."""
        return math.prod((release.held(t) for release in self.releases), start=jnp.ones(()))


def spliced(model: Model) -> Iterator[Spliced]:
    """Where lines of a model bend as one."""
    cuts = [tuple(sorted(j.members, key=_after)) for j in model.junctions if j.cut]
    for one, other in (*cuts, *model.rigid_joints):
        names = one[0], other[0]
        if all(n in model.lines and model.lines[n].bending is not None for n in names):
            ends = (model.end(*one), model.end(*other))
            yield Spliced((one, other), tuple(e.release for e in ends if e.release is not None))


def bent_over(model: Model) -> set[LineEnd]:
    """The ends at which the bending of a line goes on in another."""
    return {end for each in spliced(model) for end in each.ends}


def _after(end: LineEnd) -> bool:
    return end[1] == 0


def meeting(model: Model, found: Spliced, shapes: Mapping[str, Shape]) -> tuple[Side, Side]:
    """The two lines where they bend as one."""
    sides = []
    for name, node in found.ends:
        bending = model.lines[name].bending
        assert bending is not None
        sides.append(Side(bending.EI, shapes[name], node))
    return sides[0], sides[1]


def splices(
    model: Model,
    t: Float[Array, ""],
    shapes: Mapping[str, Shape],
    dt: Float[Array, ""] | None = None,
) -> tuple[Splice, ...]:
    """What bends over the joints of a model at t (s), of a kick of dt (s) there if steps are fixed."""
    found = []
    for each in spliced(model):
        sides = meeting(model, each, shapes)
        energy, couples = bent(*sides)
        power = None
        if each.releases:
            held = each.held(t).astype(energy.dtype)
            couples = tuple(held * couple for couple in couples)
            left, rate = (x.astype(energy.dtype) for x in _fading(each, t, dt))
            energy, power = left * energy, rate * energy
        names = [name for name, _ in each.ends]
        forces, shares = {}, dict(zip(names, softness(*sides), strict=True))
        for (name, node), couple in zip(each.ends, couples, strict=True):
            others = shapes[name].tangent.shape[1] - 1
            force = jnp.pad(couple, ((0, 0), (0, others) if node == 0 else (others, 0)))
            forces[name] = force
        found.append(Splice(forces, shares, energy, power))
    return tuple(found)


def moments(
    model: Model, t: Float[Array, ""], shapes: Mapping[str, Shape]
) -> dict[str, Float[Array, " nodes"]]:
    """Sizes of the bending moments (N m) at the nodes of each line that bends, at t (s).

    Where a line breaks away from another that it bends with, of both what is left of the moment over
    the node that they share.
    """
    found = {
        name: line.bending.moment(shapes[name])
        for name, line in model.lines.items()
        if line.bending is not None
    }
    for each in spliced(model):
        left = moment_across(*meeting(model, each, shapes))
        if each.releases:
            left = each.held(t).astype(left.dtype) * left
        for name, node in each.ends:
            found[name] = found[name].at[node].set(left)
    return found


def _fading(each: Spliced, t: Float[Array, ""], dt: Float[Array, ""] | None):
    """The share of the energy that is left (-) and its rate (1/s).

    Kicks exchange energy with the motion by the trapezoidal rule, sum (h_n + h_n+1) (E_n+1 - E_n) / 2
    of the share h and the energy E; what that leaves of the change of h E is
    sum (h_n+1 - h_n) (E_n + E_n+1) / 2, to which each kick adds (h_n+1 - h_n-1) E_n / 2. Half of the
    last one is done at t: the rest is there, and the account closes whatever the share does.
    """
    if dt is None:
        return jax.jvp(each.held, (t,), (jnp.ones_like(t),))
    before, now, after = (each.held(t + step) for step in (-dt, 0.0, dt))
    return 0.25 * (before + 2.0 * now + after), (after - before) / (2.0 * dt)


def add_splices(
    model: Model, t: Float[Array, ""], found: Found, dt: Float[Array, ""] | None
) -> None:
    """Work out what bends over the joints of a model at t (s), and add it to the forces of the lines."""
    shapes = {name: e.line.shape for name, e in found.items()}
    found.splices = splices(model, t, shapes, dt)
    for splice in found.splices:
        for name, force in splice.forces.items():
            e = found[name]
            found[name] = e._replace(line=e.line._replace(force=e.line.force + force))
