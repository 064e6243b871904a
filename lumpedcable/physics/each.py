"""Functions of the numbers at one place, with slopes that are worked out once for all directions."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array, Float

__all__ = ["at_each"]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def at_each(of: Callable[[Any, Any], Any], given: Any, values: Any) -> Any:
    """`of(given, values)`, for a function that makes its results at a place of the values there alone.

    The result r is the same. Its change is dr = sum over k of (dr/dv_k) dv_k for the values v_k that
    change, and the slopes dr/dv_k at each place are worked out once, by one way back through `of` for
    each result: a direction then costs one multiplication for each value. jax's own rule would repeat
    a good part of `of` in every direction that it follows.

    Args:
        of: results, all of one shape, of what is given and of values; trees of arrays or None.
        given: what has no derivative, such as masks.
        values: floats, one of them of the shape of the results, the others of one that goes with it.
    """
    return of(given, values)


def _changes(of, primals, tangents):
    given, values = primals
    leaves, tree = jax.tree.flatten(values)
    changes = jax.tree.leaves(tangents[1], is_leaf=lambda t: isinstance(t, SymbolicZero))
    moved = [k for k, change in enumerate(changes) if not isinstance(change, SymbolicZero)]

    def by_moved(*some):
        mine = dict(zip(moved, some, strict=True))
        return of(given, jax.tree.unflatten(tree, [mine.get(k, x) for k, x in enumerate(leaves)]))

    shape = jnp.broadcast_shapes(*(jnp.shape(x) for x in leaves))
    results, back = jax.vjp(by_moved, *(jnp.broadcast_to(leaves[k], shape) for k in moved))
    parts, form = jax.tree.flatten(results)

    def change_of(which: int) -> Array:
        picked = [jnp.full_like(p, float(k == which)) for k, p in enumerate(parts)]
        slopes = back(jax.tree.unflatten(form, picked))
        steps = [_settled(s) * changes[k] for s, k in zip(slopes, moved, strict=True)]
        return functools.reduce(jnp.add, steps)

    return results, jax.tree.unflatten(form, [change_of(k) for k in range(len(parts))])


at_each.defjvp(_changes, symbolic_zeros=True)


def _settled(x: Float[Array, "..."]) -> Float[Array, "..."]:
    """The same numbers, in a way that XLA's CPU compiler works them out before they are used.

    What is cheap it would put into every loop that reads it, however many times that does the same; a
    division it leaves where it is.
    """
    return x / jnp.where(jnp.isnan(x), x, 1.0)
