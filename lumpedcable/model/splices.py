"""Lines with bending that are to break along their length: their parts bend as one until they do.

The two parts of a line meet at a joint, where they share a node. What bends over that node belongs to
neither; while the line breaks there it fades like the force does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.couple import Found
from lumpedcable.model.ends import Release
from lumpedcable.model.evaluation import Splice
from lumpedcable.model.model import Model
from lumpedcable.physics.bending import Bending, bent, moment_across
from lumpedcable.physics.load import Shape

__all__ = ["add_splices", "moments", "spliced", "splices"]


def spliced(model: Model) -> Iterator[tuple[str, str, Bending, Release]]:
    """The parts before and after each cut of a line with bending, its bending, and its break."""
    for index, junction in enumerate(model.junctions):
        if not junction.cut:
            continue
        part, release = {node: name for name, node in junction.members}, model.parting(index)
        for load in model.lines[part[0]].loads:
            if isinstance(load, Bending):
                assert release is not None  # a line is cut where it breaks
                yield part[-1], part[0], load, release


def splices(
    model: Model,
    t: Float[Array, ""],
    shapes: Mapping[str, Shape],
    dt: Float[Array, ""] | None = None,
) -> tuple[Splice, ...]:
    """What bends over the cuts of a model at t (s), of a kick of dt (s) there if steps are fixed."""
    found = []
    for before, after, bending, release in spliced(model):
        energy, (last, first) = bent(bending.EI, shapes[before], shapes[after])
        held = release.held(t).astype(energy.dtype)
        inner = shapes[before].tangent.shape[1] - 1, shapes[after].tangent.shape[1] - 1
        forces = {
            before: jnp.pad(held * last, ((0, 0), (inner[0], 0))),
            after: jnp.pad(held * first, ((0, 0), (0, inner[1]))),
        }
        left, rate = _fading(release, t, dt)
        found.append(
            Splice(forces, left.astype(held.dtype) * energy, rate.astype(held.dtype) * energy)
        )
    return tuple(found)


def moments(
    model: Model, t: Float[Array, ""], shapes: Mapping[str, Shape]
) -> dict[str, Float[Array, " nodes"]]:
    """Sizes of the bending moments (N m) at the nodes of each line that bends, at t (s).

    Where a line is to break, of both parts what is left of the moment over the node that they share.
    """
    found = {
        name: line.bending.moment(shapes[name])
        for name, line in model.lines.items()
        if line.bending is not None
    }
    for before, after, bending, release in spliced(model):
        whole = moment_across(bending.EI, shapes[before], shapes[after])
        left = release.held(t).astype(whole.dtype) * whole
        found[before] = found[before].at[-1].set(left)
        found[after] = found[after].at[0].set(left)
    return found


def _fading(release: Release, t: Float[Array, ""], dt: Float[Array, ""] | None):
    """The share of the energy that is left (-) and its rate (1/s).

    Kicks exchange energy with the motion by the trapezoidal rule, sum (h_n + h_n+1) (E_n+1 - E_n) / 2
    of the share h and the energy E; what that leaves of the change of h E is
    sum (h_n+1 - h_n) (E_n + E_n+1) / 2, to which each kick adds (h_n+1 - h_n-1) E_n / 2. Half of the
    last one is done at t: the rest is there, and the account closes whatever the share does.
    """
    if dt is None:
        return jax.jvp(release.held, (t,), (jnp.ones_like(t),))
    before, now, after = (release.held(t + step) for step in (-dt, 0.0, dt))
    return 0.25 * (before + 2.0 * now + after), (after - before) / (2.0 * dt)


def add_splices(
    model: Model, t: Float[Array, ""], found: Found, dt: Float[Array, ""] | None
) -> None:
    """Work out what bends over the cuts of a model at t (s), and add it to the forces of the lines."""
    shapes = {name: e.line.shape for name, e in found.items()}
    found.splices = splices(model, t, shapes, dt)
    for splice in found.splices:
        for name, force in splice.forces.items():
            e = found[name]
            found[name] = e._replace(line=e.line._replace(force=e.line.force + force))
