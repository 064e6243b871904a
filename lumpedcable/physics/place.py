"""Writing a part of an array in place: what a step along a line spends its time on otherwise.

XLA's CPU compiler inlines a concatenation into every loop that reads it, with a branch at every
element, and works out its values anew in each of them. What is written into an array is worked out
once, in a loop without branches, and if the array is carried from step to step nothing is copied. For
a single line that makes a step two to three times as fast.
"""

import functools

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.linear import AtEnd, Framed, FramedDifferences, room, tangent_of

__all__ = ["framed", "framed_differences", "place", "place_at_end"]

Index = int | Array


def place(whole: Float[Array, "..."], part: Float[Array, "..."], *start: Index) -> Array:
    """`whole` with `part`, of as many axes, from the indices `start` on; the indices are not batched."""
    return _traced(whole, part, tuple(jnp.asarray(i, jnp.int32) for i in start))


def place_at_end(
    values: Float[Array, "*d n"], node: Index, value: Float[Array, "*d"]
) -> Float[Array, "*d n"]:
    """The same values but for the first (`node` 0) or last (`node` -1) along the last axis.

    A node that is known only when the program runs is any one.
    """
    if isinstance(node, int):
        return _with_end(node, values, value)
    return jax.lax.dynamic_update_slice_in_dim(values, value[..., None], node, values.ndim - 1)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _with_end(node: int, values: Array, value: Array) -> Array:
    index = 0 if node == 0 else values.shape[-1] - 1
    return place(values, value[..., None], *(0,) * (values.ndim - 1), index)


@_with_end.defjvp
def _with_end_jvp(node, operands, tangents):
    count = operands[0].shape[-1]
    return _with_end(node, *operands), tangent_of(AtEnd(count, node), *tangents)[0]


def framed(
    first: Float[Array, "*d 1"],
    values: Float[Array, "*d n"],
    last: Float[Array, "*d 1"],
    into: Float[Array, "*d n+2"] | None = None,
) -> Float[Array, "*d n+2"]:
    """(first, values, last) along the last axis, written over `into` if there is such an array."""
    if into is None:
        return _framed(first, values, last)
    return _written_over(into, first, values, last)


def _written_over(into: Array, first: Array, values: Array, last: Array) -> Array:
    count, lead = values.shape[-1], (0,) * (values.ndim - 1)
    for part, index in ((values, 1), (first, 0), (last, count + 1)):
        into = place(into, part, *lead, index)
    return into


@jax.custom_jvp
def _framed(first: Array, values: Array, last: Array) -> Array:
    return _written_over(room(values, values.shape[-1] + 2), first, values, last)


@_framed.defjvp
def _framed_jvp(operands, tangents):
    return _framed(*operands), tangent_of(Framed(), *tangents)[0]


@jax.custom_jvp
def framed_differences(
    first: Float[Array, "*d 1"], values: Float[Array, "*d n"], last: Float[Array, "*d 1"]
) -> Float[Array, "*d n+1"]:
    """x_j+1 - x_j of (first, values, last) along the last axis."""
    framed = _framed(first, values, last)
    return framed[..., 1:] - framed[..., :-1]


@framed_differences.defjvp
def _framed_differences_jvp(operands, tangents):
    return framed_differences(*operands), tangent_of(FramedDifferences(), *tangents)[0]


# jax batches such a write as a scatter, which the compiler takes apart slowly; so it is told to write a
# batch as what it is, one more axis
@jax.custom_batching.custom_vmap
def _written(whole: Array, part: Array, start: tuple[Array, ...]) -> Array:
    return jax.lax.dynamic_update_slice(whole, part, start)


@_written.def_vmap
def _written_batch(size: int, batched, whole: Array, part: Array, start: tuple[Array, ...]):
    if any(batched[2]):
        # each run writes to a place of its own
        axes = jax.tree.map(lambda b: 0 if b else None, tuple(batched))
        return jax.vmap(jax.lax.dynamic_update_slice, axes)(whole, part, start), True
    whole, part = (
        x if b else jnp.broadcast_to(x, (size, *x.shape))
        for x, b in zip((whole, part), batched[:2], strict=True)
    )
    return _place(whole, part, (jnp.zeros((), jnp.int32), *start)), True


@jax.custom_jvp
def _place(whole: Array, part: Array, start: tuple[Array, ...]) -> Array:
    return _written(whole, part, start)


@_place.defjvp
def _place_jvp(values, tangents):
    # linear in both; the tangent is left to jax's own write, which it can transpose
    whole, part, start = values
    return _place(whole, part, start), jax.lax.dynamic_update_slice(tangents[0], tangents[1], start)


# there are hundreds of writes of few shapes: jax then follows each kind once
_traced = jax.jit(_place)
