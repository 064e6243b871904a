"""Single and double precision."""

import equinox as eqx
import jax
from jaxtyping import Array, Float, PyTree

__all__ = ["cast", "rounded_off"]


def cast(tree: PyTree, dtype: str) -> PyTree:
    """The same tree with all its floats in one precision."""
    return jax.tree.map(lambda x: x.astype(dtype) if eqx.is_inexact_array(x) else x, tree)


def rounded_off(
    total: Float[Array, "..."], old: Float[Array, "..."], step: Float[Array, "..."]
) -> Float[Array, "..."]:
    """What the rounding of `total` = old + step has left out of it, to be added with the next step.

    W. Kahan, Commun. ACM 8, 40, 1965.
    """
    return step - (total - old)
