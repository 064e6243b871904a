"""A cut in the middle of a line's arrays, at a place that is a number.

The two parts of the line stand one after the other in arrays of one length, with a hole between them: a
node that is nowhere, and a slot for a segment on either side of it, where what lies beyond each of the
two ends finds room. So one compiled program serves every place of the cut.

    segment   0 ... k-1    slot   slot   k+2 ...
    node      0 ... k      hole    k+2 ...          k: segments before the cut
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.physics.tips import BEFORE

__all__ = ["EXTRA", "Seam"]

EXTRA = 2  # nodes, and segments, that a cut adds to a line


class Seam(eqx.Module):
    """Where a line is cut: `before` is the number of its segments before the cut."""

    before: Int[Array, ""]

    def node(self, end: int, inner: int = 0) -> Int[Array, ""]:
        """Index of a node: that of an end at the cut, or so many nodes further in."""
        return self.before - inner if end == BEFORE else self.before + EXTRA + inner

    def segment(self, end: int, inner: int = 0) -> Int[Array, ""]:
        """Index of a segment: that at an end at the cut, or so many further in."""
        return self.before - 1 - inner if end == BEFORE else self.before + EXTRA + inner

    def slot(self, end: int) -> Int[Array, ""]:
        """Index of the slot beyond an end at the cut."""
        return self.before if end == BEFORE else self.before + 1

    def gap(self, segments: int) -> Bool[Array, " n"]:
        """Which of so many segments are none."""
        index = jnp.arange(segments)
        return (index == self.before) | (index == self.before + 1)

    def hole(self, nodes: int) -> Bool[Array, " nodes"]:
        """Which of so many nodes is none."""
        return jnp.arange(nodes) == self.before + 1

    def last(self, values: Float[Array, " n"], end: int, count: int) -> Float[Array, " count"]:
        """Values of the `count` segments next to an end at the cut, the end's own first."""
        if end == BEFORE:
            return jax.lax.dynamic_slice_in_dim(values, self.before - count, count)[::-1]
        return jax.lax.dynamic_slice_in_dim(values, self.before + EXTRA, count)

    def opened(self, nodes: Float[Array, "*d n+1"]) -> Float[Array, "*d n+3"]:
        """Nodal values of the whole line with the node at the cut three times: end, hole, end."""
        count = nodes.shape[-1] + EXTRA
        index = jnp.arange(count)
        whole = jnp.clip(index - jnp.clip(index - self.before, 0, EXTRA), 0, count - 1)
        return jnp.take(nodes, whole, axis=-1)

    def widened(self, segments: Float[Array, "*d n"]) -> Float[Array, "*d n+2"]:
        """Values of the whole line's segments, with some of them again in the slots."""
        count = segments.shape[-1] + EXTRA
        index = jnp.arange(count)
        whole = jnp.where(index < self.before, index, jnp.maximum(index - EXTRA, 0))
        return jnp.take(segments, whole, axis=-1)

    def parts(self, values: Float[Array, "*d n"], size: int, nodes: bool) -> tuple[Any, Any]:
        """Values before and after the cut, each filled up with NaN to `size`."""
        count = values.shape[-1]
        index = jnp.arange(size)
        first = jnp.where(index < self.before + nodes, values[..., :size], jnp.nan)
        at = self.before + EXTRA + index
        last = jnp.take(values, jnp.clip(at, 0, count - 1), axis=-1)
        return first, jnp.where(at < count, last, jnp.nan)
