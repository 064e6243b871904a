"""Numbers of a scene as arrays; any of them may be traced."""

from collections.abc import Callable, Iterable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["if_given", "number", "vector"]


def number(value: Any) -> Float[Array, ""]:
    """A number, of a strong type, so that equal types find equal programs."""
    return jnp.asarray(value, float)


def vector(values: Iterable[Any]) -> Float[Array, " n"]:
    """Several numbers."""
    return jnp.stack([number(value) for value in values])


def if_given(value: Any, read: Callable[[Any], Any] = number) -> Any:
    """What `read` makes of a value that a scene may leave out; None where it does."""
    return None if value is None else read(value)
