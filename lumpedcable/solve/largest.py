"""The largest tension of each line, and how far those of all go through the range of their laws."""

from collections.abc import Mapping
from types import MappingProxyType

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.line import Line
from lumpedcable.model.model import Model

__all__ = ["largest_tension", "reversals", "so_far", "stretches", "tensions_of"]


def largest_tension(line: Line, tension: Float[Array, " n"]) -> Float[Array, ""]:
    """The largest tension (N) of all segments that there are."""
    if line.seam is not None:
        tension = jnp.where(line.seam.gap(line.segments), -jnp.inf, tension)
    return jnp.max(tension)


def tensions_of(
    model: Model,
    along: dict[str, Float[Array, " n"]],
    at_ends: Mapping[str, Float[Array, ""]] = MappingProxyType({}),
) -> dict[str, Float[Array, ""]]:
    """The largest tension (N) of each line, "tension of NAME", and of them all, "tension".

    Of a line it is that `at_ends` too, since a segment's is that of its middle. Of them all it is so
    where loads make the two differ at rest; waves alone do for as long as they take to pass a segment.
    """
    found = {name: largest_tension(model.lines[name], t) for name, t in along.items()}
    if not found:
        return {}
    whole = dict(found)
    for name, most in at_ends.items():
        found[name] = jnp.maximum(found[name], most)
        if model.lines[name].loads:
            whole[name] = found[name]
    every = {"tension": jnp.max(jnp.stack(list(whole.values())))}
    return every | {_of(name): most for name, most in found.items()}


def so_far(
    model: Model,
    now: dict[str, Float[Array, ""]],
    peaks: dict[str, Float[Array, " n"]],
    borne: tuple[str, ...],
) -> dict[str, Float[Array, ""]]:
    """`Sample.largest` with the largest tensions of any step, where there are `peaks` of segments (N).

    Of single lines it keeps those of `borne`.
    """
    most = dict(now)
    for name, value in tensions_of(model, peaks).items():
        most[name] = jnp.maximum(now[name], value)
    kept = {_of(name) for name in borne}
    most = {n: v for n, v in most.items() if n in kept or not n.startswith(_of(""))}
    return most | pulls(model, peaks)


def _of(name: str) -> str:
    return f"tension of {name}"


def stretches(model: Model, strains: dict[str, Float[Array, " n"]]) -> dict[str, Float[Array, ""]]:
    """How far elastic lines are stretched: the largest strain over max_strain (-), and whose it is."""
    lines = {n: model.lines[n] for n in strains if not model.lines[n].inextensible}
    return _first_of(
        "stretch", model, {n: jnp.max(strains[n]) / x.max_strain for n, x in lines.items()}
    )


def pulls(model: Model, peaks: dict[str, Float[Array, " n"]]) -> dict[str, Float[Array, ""]]:
    """How hard elastic lines were pulled: largest tension over that at max_strain (-), and which.

    Of lines whose tension is that of their law alone: damping and what relaxes add to it.
    """
    shares = {}
    for name, peak in peaks.items():
        line = model.lines[name]
        if not line.inextensible and line.damping is None and line.relaxation is None:
            most = line.law.tension(line.max_strain.astype(peak.dtype))
            share = largest_tension(line, peak) / jnp.where(most > 0.0, most, 1.0)
            shares[name] = jnp.where(most > 0.0, share, 0.0)
    return _first_of("pull", model, shares)


def reversals(model: Model, turned: dict[str, Bool[Array, ""]]) -> dict[str, Float[Array, ""]]:
    """1 where a line has reversed on itself, else 0, and the first of those that have."""
    return _first_of("reversed", model, {n: jnp.asarray(x, float) for n, x in turned.items()})


def _first_of(
    what: str, model: Model, shares: dict[str, Float[Array, ""]]
) -> dict[str, Float[Array, ""]]:
    """The largest share, and the number of its line among the names of all in order; {} of none."""
    if not shares:
        return {}
    names, every = sorted(model.lines), list(shares.values())
    numbers = jnp.asarray([names.index(name) for name in shares], every[0].dtype)
    if len(every) == 1:
        return {what: every[0], f"{what} of": numbers[0]}
    stacked = jnp.stack(every)
    return {what: jnp.max(stacked), f"{what} of": numbers[jnp.argmax(stacked)]}
