"""Functions of the numbers at one place, with slopes that are worked out once for all directions."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array, Float

try:
    from jax.experimental.xla_metadata import set_xla_metadata
except ImportError:  # an experiment of jax's, which may end; without it derivatives take longer
    set_xla_metadata = None

__all__ = ["apart", "at_each", "settled"]


def at_each(
    of: Callable[[Any, Any], Any],
    given: Any,
    values: Any,
    slopes: Callable[[Any, Any], Any] | None = None,
) -> Any:
    """`of(given, values)`, for a function that makes its results at a place of the values there alone.

    The result r is the same. Its change is dr = sum over k of (dr/dv_k) dv_k for the values v_k that
    change, and the slopes dr/dv_k at each place are worked out once: by `slopes`, or one way back
    through `of` for each result. A direction then costs one multiplication for each value. jax's own
    rule would repeat a good part of `of` in every direction that it follows.

    Args:
        of: results, all of one shape, of what is given and of values; trees of arrays or None.
        given: what has no derivative, such as masks.
        values: floats, one of them of the shape of the results, the others of one that goes with it.
        slopes: where they are written down: of the same arguments, to the results and, in the place of
            each, its slopes by all values, a tree like `values` with None for those that it has not.
            What several of these need is best `settled`. Else jax finds them.
    """
    return _at_each((of, slopes), given, values)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _at_each(functions, given: Any, values: Any) -> Any:
    return functions[0](given, values)


def _changes(functions, primals, tangents):
    of, slopes = functions
    given, values = primals
    changes = jax.tree.leaves(tangents[1], is_leaf=lambda t: isinstance(t, SymbolicZero))
    moved = [k for k, change in enumerate(changes) if not isinstance(change, SymbolicZero)]
    if slopes is None:
        results, found = _by_way_back(of, given, values, moved)
    else:
        results, found = slopes(given, values)
        trees = jax.tree.structure(results).flatten_up_to(found)
        every = [jax.tree.structure(values).flatten_up_to(tree) for tree in trees]
        found = [[own[k] for k in moved] for own in every]

    def change_of(own: list[Array | None], result: Array) -> Array:
        steps = [s * changes[k] for s, k in zip(own, moved, strict=True) if s is not None]
        return functools.reduce(jnp.add, steps) if steps else jnp.zeros_like(result)

    parts, form = jax.tree.flatten(results)
    return results, jax.tree.unflatten(form, list(map(change_of, found, parts)))


def _by_way_back(of, given, values, moved: list[int]):
    """The results, and for each of them its slopes by the values that are `moved`, as jax finds them."""
    leaves, tree = jax.tree.flatten(values)

    def by_moved(*some):
        mine = dict(zip(moved, some, strict=True))
        return of(given, jax.tree.unflatten(tree, [mine.get(k, x) for k, x in enumerate(leaves)]))

    shape = jnp.broadcast_shapes(*(jnp.shape(x) for x in leaves))
    results, back = jax.vjp(by_moved, *(jnp.broadcast_to(leaves[k], shape) for k in moved))
    parts, form = jax.tree.flatten(results)
    found = []
    for which in range(len(parts)):
        picked = [jnp.full_like(p, float(k == which)) for k, p in enumerate(parts)]
        found.append([settled(s) for s in back(jax.tree.unflatten(form, picked))])
    return results, found


_at_each.defjvp(_changes, symbolic_zeros=True)


def apart(of: Callable[..., Any], *operands: Array) -> Any:
    """`of(*operands)`, in a way that XLA's CPU compiler works it out by itself, before it is used.

    What is cheap it would put into every loop that reads it, however many times that does the same. A
    call that is marked as not to be put in line it leaves where it is, and hands its arrays on.
    Elsewhere this is nothing at all. `of` is a function by itself, that knows nothing around it.
    """
    if set_xla_metadata is None or jax.default_backend() != "cpu":
        return of(*operands)
    with set_xla_metadata(inlineable="false"):
        return _apart(of, *operands)


@functools.partial(jax.jit, static_argnums=0, inline=False)
def _apart(of: Callable[..., Any], *operands: Array) -> Any:
    return of(*operands)


def settled(x: Float[Array, "..."]) -> Float[Array, "..."]:
    """The same numbers, worked out before they are used: see `apart`."""
    return apart(_same, x)


def _same(x: Array) -> Array:
    return x * 1.0  # jax would take x alone past the call
