"""Linear operations along a line, with the way back written down.

jax finds the way back of each slice and of each write by itself: an array of zeros with a part of it
filled in, or all but a part. The way back of a step would be a long list of these.
"""

import abc
import functools
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend import core
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float, Int

from lumpedcable.physics.each import apart, settled

__all__ = [
    "AbstractLinear",
    "AtEnd",
    "Framed",
    "FramedDifferences",
    "applied",
    "differences",
    "neighbours",
    "pick",
    "room",
    "settled_back",
    "sides",
    "tangent_of",
]

Arrays = tuple[Array, ...]


class AbstractLinear(abc.ABC):
    """A linear operation along the last axis of its operands, with its transpose."""

    @abc.abstractmethod
    def there(self, *operands: Array) -> Arrays:
        """The results; operands may have more axes before their own, the same ones."""

    @abc.abstractmethod
    def back(self, *results: Array) -> Arrays:
        """What the transpose makes of arrays like the results: arrays like the operands."""


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def applied(of: AbstractLinear, *operands: Array) -> Arrays:
    """`of.there(*operands)`, with `of.back` as its way back."""
    return of.there(*operands)


@applied.defjvp
def _applied_jvp(of, operands, tangents):
    return applied(of, *operands), tangent_of(of, *tangents)


# Only tangents meet the operation that jax knows nothing of: values go by jax's own.
_linear = core.Primitive("along_line")
_linear.multiple_results = True


def tangent_of(of: AbstractLinear, *operands: Array) -> Arrays:
    """`of.there(*operands)`, which jax transposes to `of.back`."""
    return tuple(_bound(of, False, operands))


def _bound(of: AbstractLinear, back: bool, operands: Any) -> list[Array]:
    operands = [jnp.asarray(x) for x in operands]
    jaxpr = _followed(of, back, tuple((x.shape, x.dtype) for x in operands))
    return _linear.bind(*operands, of=of, back=back, jaxpr=jaxpr)


@functools.cache
def _followed(of: AbstractLinear, back: bool, kinds: tuple[Any, ...]) -> core.ClosedJaxpr:
    examples = (jax.ShapeDtypeStruct(shape, dtype) for shape, dtype in kinds)
    return jax.make_jaxpr(of.back if back else of.there)(*examples)


def _evaluated(*operands, jaxpr, **_):
    return core.jaxpr_as_fun(jaxpr)(*operands)


def _transposed(cotangents, *operands, of, back, jaxpr):
    whole = (
        jnp.zeros(a.shape, a.dtype) if type(ct) is ad.Zero else ct
        for ct, a in zip(cotangents, jaxpr.out_avals, strict=True)
    )
    found = _bound(of, not back, whole)
    return [
        ct if ad.is_undefined_primal(x) else None for ct, x in zip(found, operands, strict=True)
    ]


def _batched(operands, axes, *, of, back, **_):
    size = next(x.shape[a] for x, a in zip(operands, axes, strict=True) if a is not None)
    first = (
        jnp.broadcast_to(x, (size, *x.shape)) if a is None else jnp.moveaxis(x, a, 0)
        for x, a in zip(operands, axes, strict=True)
    )
    found = _bound(of, back, first)
    return found, [0] * len(found)


_linear.def_impl(lambda *operands, jaxpr, **_: jax.jit(core.jaxpr_as_fun(jaxpr))(*operands))
_linear.def_abstract_eval(lambda *_, jaxpr, **__: jaxpr.out_avals)
ad.deflinear2(_linear, _transposed)
batching.primitive_batchers[_linear] = _batched
mlir.register_lowering(_linear, mlir.lower_fun(_evaluated, multiple_results=True))


# --- the operations ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Differences(AbstractLinear):
    def there(self, *operands):
        (x,) = operands
        return (x[..., 1:] - x[..., :-1],)

    def back(self, *results):
        # by itself once it is there, so that nothing of it is worked out anew
        return (apart(_between, results[0]),)


def _between(x: Float[Array, "*d n"]) -> Float[Array, "*d n+1"]:
    """What comes back to each end of the differences."""
    return _filled((x[..., :-1] - x[..., 1:], 1), (-x[..., :1], 0), (x[..., -1:], -1))


def room(values: Float[Array, "*d n"], count: int) -> Float[Array, "*d count"]:
    """An array of the precision of the values, `count` long, to write them and their neighbours into.

    Its numbers are all different: what is written into equal ones XLA would work out in every loop that
    reads it, with a branch at each element.
    """
    return jnp.broadcast_to(jnp.arange(count, dtype=values.dtype), (*values.shape[:-1], count))


def _filled(*parts: tuple[Array, int]) -> Array:
    """An array made of these parts, each from its index on, counted from the end if it is negative."""
    count = sum(part.shape[-1] for part, _ in parts)
    whole, lead = room(parts[0][0], count), (0,) * (parts[0][0].ndim - 1)
    for part, index in parts:
        whole = jax.lax.dynamic_update_slice(whole, part, (*lead, index % count))
    return whole


@dataclass(frozen=True)
class Framed(AbstractLinear):
    """(first, values, last): see `physics.place.framed`."""

    def there(self, *operands: Array) -> Arrays:
        """(first, values, last) as one array."""
        first, values, last = operands
        return (_filled((values, 1), (first, 0), (last, -1)),)

    def back(self, *results: Array) -> Arrays:
        """The three parts of one array."""
        (x,) = results
        return x[..., :1], x[..., 1:-1], x[..., -1:]


@dataclass(frozen=True)
class FramedDifferences(AbstractLinear):
    """The differences of (first, values, last)."""

    def there(self, *operands: Array) -> Arrays:
        """x_j+1 - x_j of the three as one array."""
        return _Differences().there(*Framed().there(*operands))

    def back(self, *results: Array) -> Arrays:
        """Those of what comes back, with the sign turned."""
        (x,) = results
        return -x[..., :1], x[..., :-1] - x[..., 1:], x[..., -1:]


@dataclass(frozen=True)
class _Neighbours(AbstractLinear):
    own: bool

    def there(self, *operands):
        (x,) = operands
        three = x[..., :-2], x[..., 1:-1], x[..., 2:]
        return three if self.own else three[::2]

    def back(self, *results):
        left, right = results[0], results[-1]
        # what comes back to each value of its own, and from its neighbours, if it has these
        own = results[1] if self.own else jnp.zeros_like(left)
        if own.shape[-1] == 1:
            return (_filled((own, 1), (left, 0), (right, -1)),)
        first, last = left[..., :1], right[..., -1:]
        second = own[..., :1] + left[..., 1:2]
        last_but_one = own[..., -1:] + right[..., -2:-1]
        within = own[..., 1:-1] + (left[..., 2:] + right[..., :-2])
        return (_filled((within, 2), (second, 1), (last_but_one, -2), (first, 0), (last, -1)),)


def _elsewhere(index: int, count: int, dtype) -> Float[Array, " count"]:
    """0 in this place and 1 in all others.

    As a number and not a condition: an array of these would be kept in bytes, and taking it apart again
    would cost more than what it is for. It comes from a distance, or XLA would make a condition of it.
    """
    return jnp.minimum(jnp.abs(jnp.arange(count, dtype=dtype) - index % count), 1.0)


@dataclass(frozen=True)
class _Pick(AbstractLinear):
    count: int
    index: int

    def there(self, *operands):
        return (operands[0][..., self.index],)

    def back(self, *results):
        x = results[0][..., None]
        return (x * (1.0 - _elsewhere(self.index, self.count, x.dtype)),)


@dataclass(frozen=True)
class AtEnd(AbstractLinear):
    """(values, value) to the same values but for one: see `physics.place.place_at_end`."""

    count: int
    index: int

    def there(self, *operands: Array) -> Arrays:
        """The values with the one in its place."""
        values, value = operands
        at = (*(0,) * (values.ndim - 1), self.index % self.count)
        return (jax.lax.dynamic_update_slice(values, value[..., None], at),)

    def back(self, *results: Array) -> Arrays:
        """The values with 0 in that place, and what was there."""
        (x,) = results
        return x * _elsewhere(self.index, self.count, x.dtype), x[..., self.index]


@dataclass(frozen=True)
class _SettledBack(AbstractLinear):
    def there(self, *operands):
        return operands

    def back(self, *results):
        return tuple(settled(x) for x in results)


def differences(x: Float[Array, "*d n+1"]) -> Float[Array, "*d n"]:
    """x_j+1 - x_j along the last axis."""
    return applied(_Differences(), x)[0]


def neighbours(framed: Float[Array, "*d n+2"]) -> tuple[Float[Array, "*d n"], ...]:
    """Of (first, values, last): what is left of each value, the values, what is right of each."""
    return applied(_Neighbours(own=True), framed)


def sides(framed: Float[Array, "*d n+2"]) -> tuple[Float[Array, "*d n"], ...]:
    """`neighbours` without the values."""
    return applied(_Neighbours(own=False), framed)


def pick(values: Float[Array, "*d n"], index: int | Int[Array, ""]) -> Float[Array, "*d"]:
    """The values at one place along the last axis, counted from the end if it is negative.

    A place that is known only when the program runs is counted from the start.
    """
    if isinstance(index, int):
        return applied(_Pick(values.shape[-1], index), values)[0]
    return jax.lax.dynamic_index_in_dim(values, index, values.ndim - 1, keepdims=False)


def settled_back(x: Float[Array, "..."]) -> Float[Array, "..."]:
    """x itself, of which what comes back is `settled`: for what many derivatives are made of."""
    return applied(_SettledBack(), x)[0]
