"""A tree of arrays as one array, for calls of compiled programs.

A call costs one or two microseconds for every array that comes back from it, and a run is some sixty of
them: as much as thirty steps of a short line.
"""

from math import prod
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, PyTree

__all__ = ["Form", "Packed", "pack", "unpacked"]


class Form(NamedTuple):
    """What a tree is but for its numbers: its structure, and shape and type of every array."""

    tree: Any
    shapes: tuple[tuple[int, ...], ...]
    types: tuple[str, ...]

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return sum(map(prod, self.shapes))


class Packed(eqx.Module):
    """The numbers (..., n) of a tree one after the other, in float64, which holds all that there are."""

    numbers: Float[Any, "... n"]
    form: Form = eqx.field(static=True)

    def tree(self) -> Any:
        """The tree; the leading axes of `numbers` become those of every array."""
        found, first, lead = [], 0, self.numbers.shape[:-1]
        for shape, kind in zip(self.form.shapes, self.form.types, strict=True):
            part = self.numbers[..., first : first + prod(shape)]
            found.append(part.reshape(*lead, *shape).astype(kind, copy=False))
            first += prod(shape)
        return jax.tree.unflatten(self.form.tree, found)


def unpacked(tree: Any) -> Any:
    """The tree that is packed, or what is not packed as it is."""
    return tree.tree() if isinstance(tree, Packed) else tree


def pack(tree: PyTree) -> Packed:
    """A tree of arrays as one, to be traced."""
    leaves, structure = jax.tree.flatten(tree)
    form = Form(structure, tuple(x.shape for x in leaves), tuple(str(x.dtype) for x in leaves))
    return Packed(jnp.concatenate([jnp.ravel(x).astype(np.float64) for x in leaves]), form)
