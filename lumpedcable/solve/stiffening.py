"""Static equilibrium of lines that keep, or all but keep, their length: in stages of stiffness."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.model.line import Line, placed
from lumpedcable.model.materials import rest_stiffness
from lumpedcable.model.model import Model, Vectors
from lumpedcable.physics.tension import Linear, Rigid, TensionOnly
from lumpedcable.scene import Scene
from lumpedcable.solve.clamps import pushes_on_bed
from lumpedcable.solve.resting import slope_under
from lumpedcable.solve.softening import STAGES
from lumpedcable.solve.statics import Equilibrium, equilibrium

__all__ = ["stiffening"]

MORE = 8  # stages that take the stretch out of rods
STIFFEST = 1e6  # of the largest tension: more would be rounding in the tensions
SOFTEST = 1e3  # of it at the end, which leaves none
TIGHT = 1e-7  # strain at which rods keep their length


class _Stage(NamedTuple):
    """How a stage ends: nodes (m) of all lines, tensions (N) and largest strain of rods."""

    places: Vectors
    tension: dict[str, Float[Array, " n"]]
    imbalance: Float[Array, ""]
    converged: Bool[Array, ""]
    iterations: Int[Array, ""]
    strain: Float[Array, ""]


def stiffening(
    scene: Scene, model: Model, tolerance: Float[Array, ""], max_iterations: int, given: bool
) -> Equilibrium:
    """Equilibrium; of inextensible lines in stages of growing stiffness, each from the one before.

    Along a bed with a profile nodes of a first shape are crowded: lines that push begin there as if they
    did not, lest some stay struts, folded back upon their neighbours.

    Rods begin as soft springs. From their own EA on, ten times stiffer at each stage, up to `STIFFEST`
    times what they carry, they begin it with the tension that they have: their strain falls to nothing.
    The last stage is a soft one, whose tensions have no rounding. Rods with `EA` end at theirs. Where
    lines are a little too short, by rounded numbers, and stretch for ever, the state before is kept.
    """
    if not given and any(map(_pushed_together, model.lines.values())):
        slack = stiffening(scene, _slackened(model), tolerance, max_iterations, given)
        # ends keep the derivatives of their places
        change = jax.lax.stop_gradient(
            {n: slack.model.lines[n].reference - line.reference for n, line in model.lines.items()}
        )
        at = model.placed({n: line.reference + change[n] for n, line in model.lines.items()})
        return equilibrium(at, tolerance, max_iterations)
    rods = [name for name, line in model.lines.items() if line.inextensible]
    if not rods:
        return equilibrium(model, tolerance, max_iterations)
    first = {name: rest_stiffness(scene, name) for name in rods}

    def stage(carry, now):
        places, tension = carry
        share, keeps, ends = now
        laws = {}
        for name in rods:
            own = model.lines[name]
            if own.give is None:
                laws[name] = _rigid(first[name], tension[name], share, keeps, ends)
            else:
                EA = own.law.tension(jnp.ones(()))
                laws[name] = Linear(jnp.where(ends, EA, jnp.minimum(EA, share * first[name])))
        lines = {name: placed(line, places[name]) for name, line in model.lines.items()}
        for name, law in laws.items():
            lines[name] = eqx.tree_at(lambda x: x.law, lines[name], law)
        at = eqx.tree_at(lambda m: m.lines, model, lines)
        found = equilibrium(at, tolerance, max_iterations)
        after = {name: line.reference for name, line in found.model.lines.items()}
        strain = {name: found.model.lines[name].reference_strain for name in rods}
        tension = {name: laws[name].tension(strain[name]) for name in rods}
        most = jnp.max(jnp.stack([jnp.zeros(()), *(jnp.max(jnp.abs(e)) for e in strain.values())]))
        end = _Stage(after, tension, found.imbalance, found.converged, found.iterations, most)
        return (after, tension), end

    start = {name: line.reference for name, line in model.lines.items()}
    nothing = {name: jnp.zeros(model.lines[name].segments) for name in rods}
    k = jnp.arange(STAGES + MORE)
    now = 10.0 ** (k + 1.0 - STAGES), k >= STAGES, k == STAGES + MORE - 1
    _, every = jax.lax.scan(stage, (start, nothing), now)
    end = jax.tree.map(lambda x: x[-1], every)
    if any(model.lines[name].give is None for name in rods):
        tight = end.converged & (end.strain <= TIGHT)
        end = jax.tree.map(lambda x: jnp.where(tight, x[-1], x[STAGES - 1]), every)
    lines = {name: placed(line, end.places[name]) for name, line in model.lines.items()}
    for name in rods:
        if lines[name].give is None:  # stiff again, for what vibrates
            EA = _stiffest(first[name], end.tension[name])
            law = Rigid(end.tension[name] - EA * lines[name].reference_strain, EA)
            lines[name] = eqx.tree_at(lambda x: x.law, lines[name], law)
    there = eqx.tree_at(lambda m: m.lines, model, lines)
    return Equilibrium(there, end.imbalance, end.converged, jnp.sum(every.iterations))


def _slackened(model: Model) -> Model:
    """The model with laws that do not push along lines on a bed with a profile."""
    lines = {
        name: eqx.tree_at(lambda x: x.law, line, TensionOnly(line.law, line.max_strain))
        for name, line in model.lines.items()
        if _pushed_together(line)
    }
    return eqx.tree_at(lambda m: m.lines, model, model.lines | lines)


def _pushed_together(line: Line) -> bool:
    """Whether a line can push on a bed with a profile: a strut of nodes that are crowded there."""
    return slope_under(line) is not None and pushes_on_bed(line)


def _rigid(first, tension, share, keeps, ends) -> Rigid:
    """The law of rods at a stage, from the `tension` (N) of the one before and their `first` EA (N)."""
    most = _stiffest(first, tension)
    least = jnp.maximum(first * 10.0 ** (1.0 - STAGES), most * (SOFTEST / STIFFEST))
    EA = jnp.where(keeps, jnp.minimum(share * first, most), share * first)
    return Rigid(jnp.where(keeps, tension, 0.0), jnp.where(ends, least, EA))


def _stiffest(first, tension) -> Float[Array, ""]:
    """The largest EA (N) of rods that carry a `tension` (N), which is no less than the `first`."""
    carried = jnp.max(jnp.abs(jax.lax.stop_gradient(tension)))
    return jnp.maximum(first, STIFFEST * carried)
