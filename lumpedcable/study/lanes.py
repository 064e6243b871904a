"""A function of one run, for many runs at once, with the runs along the last axis of every array.

`jax.vmap` puts the runs first: every loop of the compiled program then goes along one line's nodes, and
its vector instructions stop short at the end of each line. With the runs last, a loop goes over nodes
and runs together, neighbouring nodes are a fixed number of runs apart, and nothing is left over if the
runs are a multiple of the vector's width. On a CPU that is two to three times as fast.

The function is traced once, for one run. Of its operations those that a step consists of are carried
over here; whatever else occurs is left to `jax.vmap`, with the runs along the last axis.
"""

import weakref
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax
from jax.extend import core

__all__ = ["across"]

Values = list[Any]
Flags = list[bool]  # which values differ from run to run
Found = tuple[Values, Flags]

# operations that act on every element alone
ELEMENTWISE = frozenset((
    "abs", "acos", "acosh", "add", "add_any", "and", "asin", "asinh", "atan", "atan2", "atanh", "cbrt",
    "ceil", "clamp", "convert_element_type", "copy", "cos", "cosh", "div", "eq", "erf",
    "erf_inv", "erfc", "exp", "exp2", "expm1", "floor", "ge", "gt", "integer_pow",
    "is_finite", "le", "lgamma", "log", "log1p", "logistic", "lt", "max", "min", "mul",
    "ne", "neg", "nextafter", "not", "or", "pow", "reduce_precision", "rem", "round",
    "rsqrt", "select_n", "sign", "sin", "sinh", "sqrt", "square", "sub", "tan", "tanh",
    "xor",
))  # fmt: skip
# operations along given axes, which stay the same axes
ALONG = frozenset((
    "argmax", "argmin", "cumlogsumexp", "cummax", "cummin", "cumprod", "cumsum",
    "reduce_and", "reduce_max", "reduce_min", "reduce_or", "reduce_prod", "reduce_sum",
    "reduce_xor", "rev", "squeeze",
))  # fmt: skip
INLINE = {"jit": "jaxpr", "pjit": "jaxpr", "closed_call": "call_jaxpr", "core_call": "call_jaxpr",
          "custom_jvp_call": "call_jaxpr", "custom_vjp_call": "call_jaxpr",
          "custom_vmap_call": "call", "checkpoint": "jaxpr"}  # fmt: skip
_MARKS: weakref.WeakKeyDictionary[Any, dict[tuple[bool, ...], Flags]] = weakref.WeakKeyDictionary()
FOLDED = {"reduce_sum": lax.add, "reduce_max": lax.max, "reduce_min": lax.min,
          "reduce_and": lax.bitwise_and, "reduce_or": lax.bitwise_or}  # fmt: skip
FEW_RUNS = 8  # fewer do not fill a vector
LONG = 32  # nor does an axis that is longer, unless it is taken in pieces
WIDTH = 8  # as wide as a vector, or a multiple of it
FEW = 16  # terms of a product that is written as a sum; a library call costs more


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
    found, flags = _evaluate(closed, last, [True] * len(last), size)
    whole = (_spread(x, b, size) for x, b in zip(found, flags, strict=True))
    result = [jnp.moveaxis(x, -1, 0) for x in whole]
    return jax.tree.unflatten(jax.tree.structure(shapes), result)


def _spread(x: Any, batched: bool, size: int) -> Any:
    """The value with a last axis of runs."""
    if batched:
        return x
    x = jnp.asarray(x)
    return lax.broadcast_in_dim(x, (*x.shape, size), range(x.ndim))


def _evaluate(closed: Any, values: Values, flags: Flags, size: int) -> Found:
    """The outputs of a traced function, and which of them differ from run to run."""
    jaxpr = closed.jaxpr
    known: dict[Any, tuple[Any, bool]] = {}
    known |= {v: (c, False) for v, c in zip(jaxpr.constvars, closed.consts, strict=True)}
    known |= {v: (x, b) for v, x, b in zip(jaxpr.invars, values, flags, strict=True)}

    def read(atom: Any) -> tuple[Any, bool]:
        return (atom.val, False) if isinstance(atom, core.Literal) else known[atom]

    for eqn in jaxpr.eqns:
        found = [read(atom) for atom in eqn.invars]
        operands, which = [x for x, _ in found], [b for _, b in found]
        if any(which):
            results, marks = _apply(eqn, operands, which, size) or _otherwise(eqn, jaxpr, known)
        else:
            run, variables = _alone(eqn, jaxpr)
            results = run(*(known[v][0] for v in variables))
            marks = [False] * len(results)
        known.update(zip(eqn.outvars, zip(results, marks, strict=True), strict=True))
    ends = [read(atom) for atom in jaxpr.outvars]
    return [x for x, _ in ends], [b for _, b in ends]


def _alone(eqn: Any, jaxpr: Any) -> tuple[Callable[..., Values], list[Any]]:
    """An operation as a function of its operands that are variables; and which these are."""
    variables = list(dict.fromkeys(v for v in eqn.invars if not isinstance(v, core.Literal)))
    kept = [v for v in eqn.outvars if not isinstance(v, core.DropVar)]
    alone = core.Jaxpr((), variables, kept, [eqn], eqn.effects, jaxpr.debug_info)
    function = core.jaxpr_as_fun(core.ClosedJaxpr(alone, ()))

    def run(*values):
        found = iter(function(*values))
        return [None if isinstance(v, core.DropVar) else next(found) for v in eqn.outvars]

    return run, variables


def _apply(eqn: Any, operands: Values, flags: Flags, size: int) -> Found | None:
    """An operation of which some operand differs from run to run; None where there is no rule."""
    name = eqn.primitive.name
    if name in ELEMENTWISE:
        shape = (*eqn.outvars[0].aval.shape, size)
        return _all([_elementwise(eqn, operands, flags, shape)])
    if name in FOLDED and size < FEW_RUNS:
        return _all([_folded(eqn, operands[0])])
    if name in ALONG:
        return _all([eqn.primitive.bind(*operands, **eqn.params)])
    if name in INLINE:
        inner = eqn.params[INLINE[name]]
        if isinstance(inner, core.Jaxpr):
            inner = core.ClosedJaxpr(inner, ())
        return _evaluate(inner, operands, flags, size)
    rule = RULES.get(name)
    return None if rule is None else rule(eqn, operands, flags, size)


def _all(results: Values) -> Found:
    return results, [True] * len(results)


def _otherwise(eqn: Any, jaxpr: Any, known: dict[Any, tuple[Any, bool]]) -> Found:
    """What jax makes of it: also which results it knows to be the same in every run."""
    run, variables = _alone(eqn, jaxpr)
    axes = [-1 if known[v][1] else None for v in variables]
    values = [known[v][0] for v in variables]
    ends = [-1 if _differs(run, axes, values, k) else None for k in range(len(eqn.outvars))]
    found = jax.vmap(lambda *x: run(*x), in_axes=axes, out_axes=ends)(*values)
    return found, [end is not None for end in ends]


def _differs(run: Callable[..., Values], axes: list[int | None], values: Values, k: int) -> bool:
    """Whether result number k of an operation differs from run to run; jax tells by refusing."""
    try:
        jax.eval_shape(jax.vmap(lambda *x: run(*x)[k], in_axes=axes, out_axes=None), *values)
    except ValueError:
        return True
    return False


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
    return _all([lax.slice(operands[0], (*p["start_indices"], 0), ends, (*strides, 1))])


def _dynamic_slice(eqn, operands, flags, size):
    if any(flags[1:]):
        return None
    whole, *start = operands
    return _all(
        [lax.dynamic_slice(whole, (*start, _zero(start)), (*eqn.params["slice_sizes"], size))]
    )


def _dynamic_update_slice(eqn, operands, flags, size):
    if any(flags[2:]):
        return None
    whole, part, *start = operands
    whole, part = _spread(whole, flags[0], size), _spread(part, flags[1], size)
    return _all([lax.dynamic_update_slice(whole, part, (*start, _zero(start)))])


def _zero(start: Sequence[Any]) -> Any:
    return jnp.zeros((), jnp.asarray(start[0]).dtype) if start else 0


def _concatenate(eqn, operands, flags, size):
    parts = [_spread(x, b, size) for x, b in zip(operands, flags, strict=True)]
    return _all([lax.concatenate(parts, eqn.params["dimension"])])


def _stack(eqn, operands, flags, size):
    parts = [_spread(x, b, size) for x, b in zip(operands, flags, strict=True)]
    return _all([jnp.stack(parts, eqn.params["axis"])])


def _split(eqn, operands, flags, size):
    return _all(list(lax.split(operands[0], eqn.params["sizes"], eqn.params["axis"])))


def _unstack(eqn, operands, flags, size):
    return _all(list(jnp.unstack(operands[0], axis=eqn.params["axis"])))


def _pad(eqn, operands, flags, size):
    if flags[1]:
        return None
    return _all([lax.pad(operands[0], operands[1], (*eqn.params["padding_config"], (0, 0, 0)))])


def _broadcast_in_dim(eqn, operands, flags, size):
    shape, axes = eqn.params["shape"], eqn.params["broadcast_dimensions"]
    return _all([lax.broadcast_in_dim(operands[0], (*shape, size), (*axes, len(shape)))])


def _reshape(eqn, operands, flags, size):
    return _all([lax.reshape(operands[0], (*eqn.params["new_sizes"], size))])


def _transpose(eqn, operands, flags, size):
    order = eqn.params["permutation"]
    return _all([lax.transpose(operands[0], (*order, len(order)))])


def _dot_general(eqn, operands, flags, size):
    """A product with few terms as a sum of products of elements."""
    (left, right), batch = eqn.params["dimension_numbers"]
    avals = [atom.aval for atom in eqn.invars]
    terms = 1
    for axis in left:
        terms *= avals[0].shape[axis]
    if any(batch) or terms > FEW:
        return None
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
    return _all([total.astype(eqn.outvars[0].aval.dtype)])


def _settled(closed: Any, fixed: Flags, carry: Flags, more: Flags, size: int) -> Flags:
    """Which carried values differ from run to run once a loop's body has been gone through."""
    while True:
        flags = [*fixed, *carry, *more]
        found = _marks(closed, flags, size)
        after = [a or b for a, b in zip(carry, found, strict=False)]
        if after == carry:
            return carry
        carry = after


def _marks(closed: Any, flags: Flags, size: int) -> Flags:
    """Which of the values that a function returns differ from run to run, nothing being computed.

    Found once: a loop within loops would be gone through again for each loop around it.
    """
    known = _MARKS.setdefault(closed.jaxpr, {})
    key = tuple(flags)
    if key not in known:

        def run(*values):
            results, known[key] = _evaluate(closed, list(values), flags, size)
            return results

        given = [
            jax.ShapeDtypeStruct((*a.shape, size) if b else a.shape, a.dtype)
            for a, b in zip(closed.in_avals, flags, strict=True)
        ]
        jax.eval_shape(run, *given)
    return known[key]


def _while(eqn, operands, flags, size):
    p = eqn.params
    test, body = p["cond_jaxpr"], p["body_jaxpr"]
    a, b = p["cond_nconsts"], p["cond_nconsts"] + p["body_nconsts"]
    fixed, carry = flags[a:b], _settled(body, flags[a:b], flags[b:], [], size)
    if any(_marks(test, [*flags[:a], *carry], size)):
        return None  # the runs do not go on equally long
    start = [_spread(x, True, size) if was else _spread(x, False, size) if now else x
             for x, was, now in zip(operands[b:], flags[b:], carry, strict=True)]  # fmt: skip

    def goes_on(values):
        return _evaluate(test, [*operands[:a], *values], [*flags[:a], *carry], size)[0][0]

    def step(values):
        found, marks = _evaluate(body, [*operands[a:b], *values], [*fixed, *carry], size)
        return _as(carry, found, marks, size)

    return lax.while_loop(goes_on, step, start), carry


def _as(wanted: Flags, values: Values, flags: Flags, size: int) -> Values:
    """The values with an axis of runs wherever one is wanted."""
    return [_spread(x, b, size) if w else x for w, x, b in zip(wanted, values, flags, strict=True)]


def _scan(eqn, operands, flags, size):
    p = eqn.params
    a, b = p["num_consts"], p["num_consts"] + p["num_carry"]
    body, count = p["jaxpr"], p["num_carry"]
    carry = _settled(body, flags[:a], flags[a:b], flags[b:], size)
    start = _as(carry, operands[a:b], flags[a:b], size)
    marks = _marks(body, [*flags[:a], *carry, *flags[b:]], size)

    def step(values, row):
        given = [*operands[:a], *values, *row]
        found, own = _evaluate(body, given, [*flags[:a], *carry, *flags[b:]], size)
        return _as(carry, found[:count], own[:count], size), found[count:]

    done, rows = lax.scan(step, start, operands[b:], p["length"], p["reverse"], p["unroll"])
    return [*done, *rows], [*carry, *marks[count:]]


def _cond(eqn, operands, flags, size):
    if flags[0]:
        return None
    index, values, own = operands[0], operands[1:], flags[1:]
    branches = eqn.params["branches"]
    marks = [_marks(branch, own, size) for branch in branches]
    wanted = [any(each) for each in zip(*marks, strict=True)]

    def case(branch):
        def run(*given):
            found, found_flags = _evaluate(branch, list(given), own, size)
            return _as(wanted, found, found_flags, size)

        return run

    return lax.switch(index, [case(branch) for branch in branches], *values), wanted


RULES: dict[str, Callable[..., Found | None]] = {
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
    "while": _while,
    "scan": _scan,
    "cond": _cond,
}
