"""A function of one run, for many runs at once, with the runs along the last axis of every array.

`jax.vmap` puts the runs first: every loop of the compiled program then goes along one line's nodes, and
its vector instructions stop short at the end of each line. With the runs last, a loop goes over nodes
and runs together, neighbouring nodes are a fixed number of runs apart, and nothing is left over if the
runs are a multiple of the vector's width. On a CPU that is two to three times as fast.

The function is traced once, for one run. Of its operations those that a step consists of are carried
over here; whatever else occurs is left to `jax.vmap`, with the runs along the last axis.
"""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax
from jax.extend import core

from lumpedcable.study.differing import (
    ALONG,
    ELEMENTWISE,
    INLINE,
    Flags,
    alone,
    differing,
    flow,
    inner,
    reads,
    scanned,
    variables,
)

__all__ = ["across", "evaluated"]

Values = list[Any]
FOLDED = {"reduce_sum": lax.add, "reduce_max": lax.max, "reduce_min": lax.min,
          "reduce_and": lax.bitwise_and, "reduce_or": lax.bitwise_or}  # fmt: skip
FEW_RUNS = 8  # fewer do not fill a vector
LONG = 32  # nor does an axis that is longer, unless it is taken in pieces
WIDTH = 8  # as wide as a vector, or a multiple of it


def across(function: Callable[..., Any], *arguments: Any) -> Any:
    """`function` of every run: the runs are the first axis of all arrays given and returned.

    Other than with `jax.vmap`, derivatives are to be taken inside of `function`: a rule of its own
    that an operation has for them is not carried over.
    """
    leaves, tree = jax.tree.flatten(arguments)
    size = leaves[0].shape[0]
    one = [jax.ShapeDtypeStruct(x.shape[1:], x.dtype) for x in leaves]

    def flat(*values):
        return function(*jax.tree.unflatten(tree, values))

    closed, shapes = jax.make_jaxpr(flat, return_shape=True)(*one)
    last = [jnp.moveaxis(x, 0, -1) for x in leaves]
    found, flags = evaluated(closed, last, [True] * len(last), size)
    whole = (_spread(x, b, size) for x, b in zip(found, flags, strict=True))
    result = [jnp.moveaxis(x, -1, 0) for x in whole]
    return jax.tree.unflatten(jax.tree.structure(shapes), result)


def _spread(x: Any, batched: bool, size: int) -> Any:
    """The value with a last axis of runs."""
    if batched:
        return x
    x = jnp.asarray(x)
    return lax.broadcast_in_dim(x, (*x.shape, size), range(x.ndim))


def evaluated(closed: Any, values: Values, flags: Flags, size: int) -> tuple[Values, Flags]:
    """The outputs of a traced function, and which of them differ from run to run.

    Args:
        closed: the function, a closed jaxpr of one run.
        values: what it is given, with the runs along the last axis of what differs from run to run.
        flags: which of them do.
        size: the number of runs.
    """
    jaxpr, which = closed.jaxpr, variables(closed, flags, size)
    known = dict(zip(jaxpr.constvars, closed.consts, strict=True))
    known |= dict(zip(jaxpr.invars, values, strict=True))

    def read(atom: Any) -> Any:
        return atom.val if isinstance(atom, core.Literal) else known[atom]

    for eqn in jaxpr.eqns:
        operands, own = [read(a) for a in eqn.invars], [reads(which, a) for a in eqn.invars]
        marks = [which[v] for v in eqn.outvars]
        if any(own) and flow(eqn, own, size) is not None:
            results = _apply(eqn, operands, own, marks, size)
        else:
            run, free = alone(eqn, jaxpr)
            given = [known[v] for v in free]
            mine = [reads(which, v) for v in free]
            results = _otherwise(run, given, mine, marks) if any(own) else run(*given)
        known.update(zip(eqn.outvars, results, strict=True))
    return [read(atom) for atom in jaxpr.outvars], differing(closed, flags, size)


def _apply(eqn: Any, operands: Values, flags: Flags, marks: Flags, size: int) -> Values:
    """The results of an operation that has a rule, with an axis of runs where `marks` says so."""
    name = eqn.primitive.name
    if name in ELEMENTWISE:
        return [_elementwise(eqn, operands, flags, (*eqn.outvars[0].aval.shape, size))]
    if name in FOLDED and size < FEW_RUNS:
        return [_folded(eqn, operands[0])]
    if name in ALONG:
        return [eqn.primitive.bind(*operands, **eqn.params)]
    if name in INLINE:
        return evaluated(inner(eqn), operands, flags, size)[0]
    if name in LOOPS:
        return LOOPS[name](eqn, operands, flags, marks, size)
    return RULES[name](eqn, operands, flags, size)


def _otherwise(run: Callable[..., Values], given: Values, flags: Flags, marks: Flags) -> Values:
    """What jax makes of an operation."""
    axes, ends = ([-1 if mark else None for mark in some] for some in (flags, marks))
    return jax.vmap(lambda *x: run(*x), in_axes=axes, out_axes=ends)(*given)


def _elementwise(eqn: Any, operands: Values, flags: Flags, shape: tuple[int, ...]) -> Any:
    rank = len(shape) - 1
    wide = []
    for x, batched in zip(operands, flags, strict=True):
        x = jnp.asarray(x)
        own = x.ndim - 1 if batched else x.ndim  # 0 where a number meets an array
        axes = [*range(own), rank] if batched else range(own)
        wide.append(x if x.shape == shape else lax.broadcast_in_dim(x, shape, axes))
    return eqn.primitive.bind(*wide, **eqn.params)


def _folded(eqn, x):
    """A reduction of few runs along the line, whose parts are laid on each other first.

    One number after the other would each wait for the one before.
    """
    axis, count = x.ndim - 2, x.shape[-2] if x.ndim > 1 else 0
    if count <= LONG or axis not in eqn.params["axes"]:
        return eqn.primitive.bind(x, **eqn.params)
    combine = FOLDED[eqn.primitive.name]
    width = WIDTH * max(count // (8 * WIDTH), 1)
    whole = count - count % width
    parts = [lax.slice_in_dim(x, k, k + width, axis=axis) for k in range(0, whole, width)]
    while len(parts) > 1:
        pairs = zip(parts[::2], parts[1::2], strict=False)
        parts = [combine(a, b) for a, b in pairs] + parts[len(parts) - len(parts) % 2 :]
    total = _folded(eqn, parts[0])
    if whole == count:
        return total
    rest = eqn.primitive.bind(lax.slice_in_dim(x, whole, count, axis=axis), **eqn.params)
    return combine(total, rest)


def _slice(eqn, operands, flags, size):
    p = eqn.params
    strides = p["strides"] or (1,) * len(p["start_indices"])
    ends = (*p["limit_indices"], size)
    return [lax.slice(operands[0], (*p["start_indices"], 0), ends, (*strides, 1))]


def _dynamic_slice(eqn, operands, flags, size):
    whole, *start = operands
    return [lax.dynamic_slice(whole, (*start, _zero(start)), (*eqn.params["slice_sizes"], size))]


def _dynamic_update_slice(eqn, operands, flags, size):
    whole, part, *start = operands
    whole, part = _spread(whole, flags[0], size), _spread(part, flags[1], size)
    return [lax.dynamic_update_slice(whole, part, (*start, _zero(start)))]


def _zero(start: Sequence[Any]) -> Any:
    return jnp.zeros((), jnp.asarray(start[0]).dtype) if start else 0


def _concatenate(eqn, operands, flags, size):
    parts = [_spread(x, b, size) for x, b in zip(operands, flags, strict=True)]
    return [lax.concatenate(parts, eqn.params["dimension"])]


def _stack(eqn, operands, flags, size):
    parts = [_spread(x, b, size) for x, b in zip(operands, flags, strict=True)]
    return [jnp.stack(parts, eqn.params["axis"])]


def _split(eqn, operands, flags, size):
    return list(lax.split(operands[0], eqn.params["sizes"], eqn.params["axis"]))


def _unstack(eqn, operands, flags, size):
    return list(jnp.unstack(operands[0], axis=eqn.params["axis"]))


def _pad(eqn, operands, flags, size):
    return [lax.pad(operands[0], operands[1], (*eqn.params["padding_config"], (0, 0, 0)))]


def _broadcast_in_dim(eqn, operands, flags, size):
    shape, axes = eqn.params["shape"], eqn.params["broadcast_dimensions"]
    return [lax.broadcast_in_dim(operands[0], (*shape, size), (*axes, len(shape)))]


def _reshape(eqn, operands, flags, size):
    return [lax.reshape(operands[0], (*eqn.params["new_sizes"], size))]


def _transpose(eqn, operands, flags, size):
    order = eqn.params["permutation"]
    return [lax.transpose(operands[0], (*order, len(order)))]


def _dot_general(eqn, operands, flags, size):
    """A product with few terms as a sum of products of elements."""
    left, right = eqn.params["dimension_numbers"][0]
    avals = [atom.aval for atom in eqn.invars]
    free = [[i for i in range(a.ndim) if i not in axes]
            for a, axes in zip(avals, (left, right), strict=True)]  # fmt: skip
    wide = []
    for k, (x, batched, own) in enumerate(zip(operands, flags, (left, right), strict=True)):
        x = _spread(x, batched, size)
        x = lax.transpose(x, (*free[k], *own, x.ndim - 1))
        here = [x.shape[i] for i in range(len(free[k]))]
        rest = x.shape[len(free[k]) :]
        other = [1] * len(free[1 - k])
        wide.append(lax.reshape(x, (*here, *other, *rest) if k == 0 else (*other, *here, *rest)))
    first = len(free[0]) + len(free[1])
    total = jnp.sum(wide[0] * wide[1], axis=tuple(range(first, first + len(left))))
    return [total.astype(eqn.outvars[0].aval.dtype)]


def _while(eqn, operands, flags, marks, size):
    p = eqn.params
    test, body = p["cond_jaxpr"], p["body_jaxpr"]
    a, b = p["cond_nconsts"], p["cond_nconsts"] + p["body_nconsts"]

    def goes_on(values):
        return evaluated(test, [*operands[:a], *values], [*flags[:a], *marks], size)[0][0]

    def step(values):
        return _as(
            marks, *evaluated(body, [*operands[a:b], *values], [*flags[a:b], *marks], size), size
        )

    return lax.while_loop(goes_on, step, _as(marks, operands[b:], flags[b:], size))


def _as(wanted: Flags, values: Values, flags: Flags, size: int) -> Values:
    """The values with an axis of runs wherever one is wanted."""
    return [_spread(x, b, size) if w else x for w, x, b in zip(wanted, values, flags, strict=True)]


def _scan(eqn, operands, flags, marks, size):
    p = eqn.params
    body, (a, count) = p["jaxpr"], scanned(eqn)
    b = a + count
    carry = marks[:count]

    def step(values, row):
        given = [*operands[:a], *values, *row]
        found, own = evaluated(body, given, [*flags[:a], *carry, *flags[b:]], size)
        return _as(carry, found[:count], own[:count], size), found[count:]

    start = _as(carry, operands[a:b], flags[a:b], size)
    done, rows = lax.scan(step, start, operands[b:], p["length"], p["reverse"], p["unroll"])
    return [*done, *rows]


def _cond(eqn, operands, flags, marks, size):
    index, values, own = operands[0], operands[1:], flags[1:]

    def case(branch):
        def run(*given):
            return _as(marks, *evaluated(branch, list(given), own, size), size)

        return run

    return lax.switch(index, [case(branch) for branch in eqn.params["branches"]], *values)


RULES: dict[str, Callable[..., Values]] = {
    "slice": _slice,
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update_slice,
    "concatenate": _concatenate,
    "stack": _stack,
    "unstack": _unstack,
    "split": _split,
    "pad": _pad,
    "broadcast_in_dim": _broadcast_in_dim,
    "reshape": _reshape,
    "transpose": _transpose,
    "dot_general": _dot_general,
}
LOOPS: dict[str, Callable[..., Values]] = {"while": _while, "scan": _scan, "cond": _cond}
