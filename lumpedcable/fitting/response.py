"""A number of a run as a function of numbers of its scene, for jax's transformations and optimisers."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from functools import partial
from numbers import Real
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float
from numpy.typing import ArrayLike, NDArray

from lumpedcable.fitting.arrays import GroupArrays, GroupSpec
from lumpedcable.fitting.once import differentiable_once
from lumpedcable.fitting.parameters import numbers_of
from lumpedcable.fitting.residual import run_group
from lumpedcable.fitting.scalar import Scalar, asked_scalar
from lumpedcable.fitting.sensitivity import picked, setting_of
from lumpedcable.scene import Study
from lumpedcable.scene.overrides import resolve
from lumpedcable.scene.quantities import Quantity
from lumpedcable.status import Status
from lumpedcable.study.compiled import RUN_OFTEN

__all__ = ["Response"]

LARGEST = float(np.finfo(float).max)


class Response:
    """y = f(x), a number y of a run by numbers x of its scene, all in SI.

    `f(x)` goes through `jax.grad`, `jax.jacfwd`, `jax.vmap` and `jax.jit`; so does `f.history(x)`. They
    have first derivatives: second ones, as of `jax.hessian`, are refused. y is computed in as many
    dimensions as the numbers can need, whatever their values: those of a run with `dimensions` given
    where they lead out of the line or plane that the scene lies in. Directions are made unit vectors.

    A run that fails at x, or whose waves become too fast there for the steps that `values` ask for, is
    NaN, and so are its derivatives. So it is where a number is none that its key may have, as a negative
    mass, and where a line at rest or at an output time is strained beyond max_strain of its material.
    Whether numbers go together, which `lumpedcable.run` looks at too, is not. Nor is it where a line has
    crumpled: what happens then hangs on the last digit, and derivatives grow without end.

    Attributes:
        of: y in words, "max velocity at rope.end"; over the output times.
        unit: of y.
        keys: full keys of the numbers x, in order.
        units: of x.
        values: x as the scene has it, shape (n,).
        time: output times of `history` in s, shape (outputs,), the start first.
    """

    def __init__(
        self, study: Study, of: str | None, by: Sequence[str], run: int = 0, spare: float = 0.0
    ) -> None:
        """See `lumpedcable.response`, which says what is raised."""
        if not (isinstance(spare, Real) and 0.0 <= spare < math.inf):
            raise ValueError(f"spare: expected a share of at least 0, found {spare!r}")
        scene = study.runs[run]
        scalar: Scalar = asked_scalar(study, of, run)
        self.of: str = str(scalar)
        self.unit: str = scalar.unit
        self.keys: tuple[str, ...]
        self.units: tuple[str, ...]
        self._bounds: NDArray[np.float64]
        self.keys, self.units, self._bounds = _numbers(study, by)
        numbers = scene.numbers()
        self.values: NDArray[np.float64] = np.array([float(numbers[key]) for key in self.keys])
        count, every = scene.output.count, float(scene.output.every)
        self.time: NDArray[np.float64] = every * np.arange(count + 1.0)
        self._reduction: str = scalar.reduction
        self._spec: GroupSpec
        self._arrays: GroupArrays
        self._spec, self._arrays = setting_of(
            scene, scalar, self.keys, back=True, spare=spare, anywhere=True
        )

    def __call__(self, x: ArrayLike) -> Float[Array, ""]:
        """y at x, shape (n,)."""
        x = self._checked(x)
        how = _value if isinstance(x, Tracer) else _value_alone
        return how(self._spec, self._arrays, self._bounds, x, self._reduction)

    def history(self, x: ArrayLike) -> Float[Array, " outputs"]:
        """The quantity that y is of, at every output time."""
        x = self._checked(x)
        how = _history if isinstance(x, Tracer) else _history_alone
        return how(self._spec, self._arrays, self._bounds, x)

    def _checked(self, x: ArrayLike) -> Float[Array, " n"]:
        try:
            x = jnp.asarray(x)
            real = jnp.issubdtype(x.dtype, jnp.floating) or jnp.issubdtype(x.dtype, jnp.integer)
        except (TypeError, ValueError):
            real = False
        if not real:
            raise ValueError(f"expected real numbers in SI units, found {x!r}")
        x = jnp.asarray(x, float)
        if x.shape != self.values.shape:
            raise ValueError(
                f"expected {len(self.keys)} numbers ({', '.join(self.keys)}), found an array of shape "
                f"{x.shape}: jax.vmap takes f over many"
            )
        return x

    def __repr__(self) -> str:
        return f"Response({self.of} ({self.unit}) by {', '.join(self.keys)})"


def _numbers(
    study: Study, by: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...], NDArray[np.float64]]:
    """Full keys of the numbers that keys or their ends mean, their units, and their bounds (2, n)."""
    if isinstance(by, str) or not by or not all(isinstance(key, str) for key in by):
        raise ValueError(f"by: expected one key or more, in a list, found {by!r}")
    data: dict[str, Any] = tomllib.loads(study.effective_text)
    data.pop("sweep", None)
    found: list[tuple[str, Quantity]] = []
    for key in by:
        path, wrong = resolve(key, 0.0, data)
        if path is None:
            raise ValueError(f"by: {wrong}")
        numbers, wrong = numbers_of(study, ".".join(map(str, path)))
        if wrong:
            raise ValueError(f"by: {wrong}")
        found += [(number.key, number.kind) for number in numbers]
    keys, kinds = zip(*found, strict=True)
    if len(set(keys)) < len(keys):
        raise ValueError(f"by: expected every number once, found {', '.join(keys)}")
    return keys, tuple(kind.unit for kind in kinds), np.transpose([_bounds(kind) for kind in kinds])


def _bounds(kind: Quantity) -> tuple[float, float]:
    """The least and the largest finite number of a kind, both included."""
    least = {"any": -LARGEST, "nonnegative": 0.0, "positive": np.finfo(float).tiny}[kind.sign]
    return float(least), LARGEST if kind.maximum is None else kind.maximum


def _history_of(spec: GroupSpec, arrays: GroupArrays, bounds, x: Float[Array, " n"]):
    found, status, _, _ = run_group(spec, arrays, differentiable_once(x))
    return _unless_failed(found[0, 0], status[0], bounds, x)


def _value_of(spec: GroupSpec, arrays: GroupArrays, bounds, x: Float[Array, " n"], reduction: str):
    found, status, _, _ = run_group(spec, arrays, differentiable_once(x))
    return _unless_failed(picked(found[0, 0], reduction), status[0], bounds, x)


def _unless_failed(
    y: Array, status: Array, bounds: Float[Array, "2 n"], x: Float[Array, " n"]
) -> Array:
    """y of a run that went well, with numbers within their bounds; otherwise NaN.

    Derivatives by every x are NaN then too: a chosen NaN alone would have the derivative 0, and an
    optimiser would see a stationary point.
    """
    low, high = bounds
    ok = (status == int(Status.OK)) & jnp.all((x >= low) & (x <= high))
    none = jnp.where(ok, 0.0, jnp.nan) * jnp.sum(x)
    return jnp.where(ok, y, jnp.nan) + none.astype(y.dtype)


# within another transformation a program takes what that is compiled with
_history = partial(jax.jit, static_argnums=0)(_history_of)
_value = partial(jax.jit, static_argnums=(0, 4))(_value_of)
_history_alone = partial(jax.jit, static_argnums=0, compiler_options=RUN_OFTEN)(_history_of)
_value_alone = partial(jax.jit, static_argnums=(0, 4), compiler_options=RUN_OFTEN)(_value_of)
