"""Numbers that a program may be differentiated by once."""

from __future__ import annotations

from typing import Any

from jax import Array
from jax.extend import core
from jax.interpreters import ad, batching, mlir
from jaxtyping import Float

__all__ = ["differentiable_once"]

# Operations that jax knows nothing of: a rule of jax.custom_jvp is gone through on a way back, and what
# is within forgets whom it belongs to.
_first, _spent = core.Primitive("differentiable_once"), core.Primitive("differentiated")


def differentiable_once(x: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """x itself, which refuses to be differentiated by a second time.

    Statics carries its derivatives through its last step, whose slopes it holds still: first
    derivatives are exact, those of them are something else.

    Raises:
        NotImplementedError: when the derivative of a derivative is asked for.
    """
    return _first.bind(x)


def _slope(primals: Any, tangents: Any) -> tuple[Array, Array]:
    return _spent.bind(*primals), tangents[0]


def _refused(primals: Any, tangents: Any) -> tuple[Array, Array]:
    raise NotImplementedError(
        "expected first derivatives of a response, found the derivative of one: second derivatives "
        "through its state of rest would be wrong, so take differences of jax.grad, or a method that "
        "needs no jax.hessian"
    )


for _one, _rule in ((_first, _slope), (_spent, _refused)):
    _one.def_impl(lambda x: x)
    _one.def_abstract_eval(lambda x: x)
    ad.primitive_jvps[_one] = _rule
    batching.defvectorized(_one)
    mlir.register_lowering(_one, lambda _, x: [x])
