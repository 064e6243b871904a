"""Which values of a traced function differ from run to run, when some of what it is given does.

Nothing is traced for it: an operation's results differ if an operand does, but for loops, branches and
what `lanes` leaves to jax, which knows better.
"""

import weakref
from collections.abc import Callable
from math import prod
from typing import Any

import jax
from jax.extend import core

__all__ = [
    "ALONG",
    "ELEMENTWISE",
    "INLINE",
    "LOOPS",
    "MOVING",
    "Flags",
    "alone",
    "differing",
    "flow",
    "inner",
    "reads",
    "scanned",
    "variables",
]

Flags = list[bool]  # which values differ from run to run

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
# operations that move values; some, where a place differs from run to run, are left to jax
MOVING = frozenset((
    "slice", "dynamic_slice", "dynamic_update_slice", "concatenate", "stack", "unstack", "split", "pad",
    "broadcast_in_dim", "reshape", "transpose", "dot_general",
))  # fmt: skip
INLINE = {"jit": "jaxpr", "pjit": "jaxpr", "closed_call": "call_jaxpr", "core_call": "call_jaxpr",
          "custom_jvp_call": "call_jaxpr", "custom_vjp_call": "call_jaxpr",
          "custom_vmap_call": "call", "checkpoint": "jaxpr", "along_line": "jaxpr"}  # fmt: skip
FEW = 16  # terms of a product that is written as a sum; a library call costs more
_KNOWN: weakref.WeakKeyDictionary[Any, dict[tuple[bool, ...], dict[Any, bool]]] = (
    weakref.WeakKeyDictionary()
)


def differing(closed: Any, flags: Flags, size: int) -> Flags:
    """Which of the values that a traced function returns differ between `size` runs.

    Args:
        closed: the function, a closed jaxpr of one run.
        flags: which of its arguments differ.
        size: the number of runs, which jax asks for where it is asked.
    """
    known = variables(closed, flags, size)
    return [reads(known, atom) for atom in closed.jaxpr.outvars]


def variables(closed: Any, flags: Flags, size: int) -> dict[Any, bool]:
    """Which of a traced function's variables differ; those that it has from outside are not told.

    Found once: a loop within loops would be gone through again for each loop around it.
    """
    jaxpr, key = closed.jaxpr, tuple(flags)
    found = _KNOWN.setdefault(jaxpr, {})
    if key not in found:
        known = dict(zip(jaxpr.invars, flags, strict=True))
        for eqn in jaxpr.eqns:
            which = [reads(known, atom) for atom in eqn.invars]
            marks = [False] * len(eqn.outvars)
            if any(which):
                marks = flow(eqn, which, size) or _asked(eqn, jaxpr, which, size)
            known.update(zip(eqn.outvars, marks, strict=True))
        found[key] = known
    return found[key]


def reads(known: dict[Any, bool], atom: Any) -> bool:
    """Whether an operand differs, a variable or a number that stands there."""
    return not isinstance(atom, core.Literal) and known.get(atom, False)


def flow(eqn: Any, flags: Flags, size: int) -> Flags | None:
    """Which results of an operation differ where some operand does; None where jax is to say."""
    name = eqn.primitive.name
    if name in INLINE:
        return differing(inner(eqn), flags, size)
    if name in LOOPS:
        return LOOPS[name](eqn, flags, size)
    if name in ELEMENTWISE or name in ALONG or (name in MOVING and not _refused(eqn, flags)):
        return [True] * len(eqn.outvars)
    return None


def _refused(eqn: Any, flags: Flags) -> bool:
    """Whether an operation that moves values is left to jax."""
    name = eqn.primitive.name
    if name == "dynamic_slice":
        return any(flags[1:])
    if name == "dynamic_update_slice":
        return any(flags[2:])
    if name == "pad":
        return flags[1]
    if name == "dot_general":
        (left, _), batch = eqn.params["dimension_numbers"]
        return any(batch) or prod(eqn.invars[0].aval.shape[axis] for axis in left) > FEW
    return False


def inner(eqn: Any) -> Any:
    """The function, a closed jaxpr, that an operation of `INLINE` stands for."""
    found = eqn.params[INLINE[eqn.primitive.name]]
    # one that is not closed has no constants; from jax 0.12 on all have
    return found if hasattr(found, "consts") else core.ClosedJaxpr(found, ())


def scanned(eqn: Any) -> tuple[int, int]:
    """How many operands of a scan are the same in every turn, and how many it carries."""
    p = eqn.params
    if "ft_in" in p:  # from jax 0.12 on
        common, carried, _ = p["ft_in"].unpack()
        return len(common), len(carried)
    return p["num_consts"], p["num_carry"]


def alone(eqn: Any, jaxpr: Any) -> tuple[Callable[..., list[Any]], list[Any]]:
    """An operation as a function of its operands that are variables; and which these are."""
    variables = list(dict.fromkeys(v for v in eqn.invars if not isinstance(v, core.Literal)))
    kept = [v for v in eqn.outvars if not isinstance(v, core.DropVar)]
    own = core.Jaxpr((), variables, kept, [eqn], eqn.effects, jaxpr.debug_info)
    function = core.jaxpr_as_fun(core.ClosedJaxpr(own, ()))

    def run(*values):
        found = iter(function(*values))
        return [None if isinstance(v, core.DropVar) else next(found) for v in eqn.outvars]

    return run, variables


def _asked(eqn: Any, jaxpr: Any, flags: Flags, size: int) -> Flags:
    """What jax says of the results of an operation: it refuses to leave out an axis that is needed."""
    run, variables = alone(eqn, jaxpr)
    which = {
        v: b for v, b in zip(eqn.invars, flags, strict=True) if not isinstance(v, core.Literal)
    }
    axes = [-1 if which[v] else None for v in variables]
    values = [
        jax.ShapeDtypeStruct((*v.aval.shape, size) if which[v] else v.aval.shape, v.aval.dtype)
        for v in variables
    ]

    def differs(k: int) -> bool:
        try:
            jax.eval_shape(jax.vmap(lambda *x: run(*x)[k], in_axes=axes, out_axes=None), *values)
        except ValueError:
            return True
        return False

    return [differs(k) for k in range(len(eqn.outvars))]


def _settled(closed: Any, fixed: Flags, carry: Flags, more: Flags, size: int) -> Flags:
    """Which carried values differ from run to run once a loop's body has been gone through."""
    while True:
        found = differing(closed, [*fixed, *carry, *more], size)
        after = [a or b for a, b in zip(carry, found, strict=False)]
        if after == carry:
            return carry
        carry = after


def _while(eqn: Any, flags: Flags, size: int) -> Flags | None:
    p = eqn.params
    a, b = p["cond_nconsts"], p["cond_nconsts"] + p["body_nconsts"]
    carry = _settled(p["body_jaxpr"], flags[a:b], flags[b:], [], size)
    # else the runs do not go on equally long
    return None if any(differing(p["cond_jaxpr"], [*flags[:a], *carry], size)) else carry


def _scan(eqn: Any, flags: Flags, size: int) -> Flags:
    body, (a, count) = eqn.params["jaxpr"], scanned(eqn)
    b = a + count
    carry = _settled(body, flags[:a], flags[a:b], flags[b:], size)
    marks = differing(body, [*flags[:a], *carry, *flags[b:]], size)
    return [*carry, *marks[count:]]


def _cond(eqn: Any, flags: Flags, size: int) -> Flags | None:
    if flags[0]:
        return None
    marks = [differing(branch, flags[1:], size) for branch in eqn.params["branches"]]
    return [any(each) for each in zip(*marks, strict=True)]


LOOPS: dict[str, Callable[[Any, Flags, int], Flags | None]] = {
    "while": _while,
    "scan": _scan,
    "cond": _cond,
}
