"""Which samples of a call of `advance` hold what: all have numbers, and some of them fields."""

from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, PyTree

from lumpedcable.physics.place import place
from lumpedcable.solve.observe import Sample

__all__ = ["field_slots", "fields_done", "put", "put_seldom", "room_for"]

Kept = TypeVar("Kept")
Count = TypeVar("Count", int, Array)


def field_slots(outputs: int, after: int) -> int:
    """Places for the fields of `outputs` outputs, wherever they begin, one for every `after` of them.

    The last of them may be of an output that is on its way to the next one with fields.
    """
    return (outputs + 2 * after - 2) // after


def fields_done(first: Count, count: Count, after: int) -> Count:
    """How many of the `count` outputs after number `first` have fields: every `after`th of a run."""
    return (first + count) // after - first // after


def room_for(shapes: PyTree, count: int) -> PyTree:
    """Zeros for `count` trees of these shapes, along a first axis of their own."""
    return jax.tree.map(lambda s: jnp.zeros((count, *s.shape), s.dtype), shapes)


def put(whole: Kept, part: Kept, at: Array) -> Kept:
    """Trees (count, ...) with another one at a place."""
    return jax.tree.map(lambda w, x: place(w, x[None], at, *(0,) * x.ndim), whole, part)


def put_seldom(whole: Sample, part: Sample, first: Array, at: Array, after: int) -> Sample:
    """As `put`, of a call whose outputs follow number `first`; fields go to where the next ones stand.

    Each overwrites those before it, so that what stays is of the outputs that have fields, and of the
    last one.
    """
    fields = put(whole.fields, part.fields, fields_done(first, at, after))
    others = put(whole._replace(fields={}), part._replace(fields={}), at)
    return others._replace(fields=fields)
