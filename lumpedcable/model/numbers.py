"""Numbers of a scene as arrays; any of them may be traced."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

if TYPE_CHECKING:
    from lumpedcable.scene import Scene

__all__ = ["if_given", "moving", "number", "vector"]


def number(value: Any) -> Float[Array, ""]:
    """A number, of a strong type, so that equal types find equal programs."""
    return jnp.asarray(value, float)


def vector(values: Iterable[Any]) -> Float[Array, " n"]:
    """Several numbers; those that are known, as a file's thousands of rows, as one array."""
    values = list(values)
    if all(isinstance(value, float | int) for value in values):
        return jnp.asarray(np.array(values, float), float)
    return jnp.stack([number(value) for value in values])


def moving(scene: "Scene") -> Float[Array, ""]:
    """1 where a scene goes through time and 0 where it is at rest (-): a share of what moves its parts.

    A number like its duration, which is no part of its structure: both share their programs.
    """
    return jnp.where(number(scene.output.duration) > 0.0, 1.0, 0.0)


def if_given(value: Any, read: Callable[[Any], Any] = number) -> Any:
    """What `read` makes of a value that a scene may leave out; None where it does."""
    return None if value is None else read(value)
