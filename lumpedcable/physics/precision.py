"""Single and double precision."""

import equinox as eqx
import jax
from jaxtyping import PyTree

__all__ = ["cast"]


def cast(tree: PyTree, dtype: str) -> PyTree:
    """The same tree with all its floats in one precision."""
    return jax.tree.map(lambda x: x.astype(dtype) if eqx.is_inexact_array(x) else x, tree)
