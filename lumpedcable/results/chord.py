"""How far along its chord the nodes of a cable are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["along_chord"]


def along_chord(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (m) nodes are from the first one towards the last, level, (runs, nodes).

    Negative behind the first node. Where the ends are over each other there is no such direction, and
    the distance is that from the plumb line through them.

    Args:
        nodes: positions (m) of a cable's nodes, (runs, 3, nodes).
    """
    level = nodes[:, :2] - nodes[:, :2, :1]
    span = np.linalg.norm(level[:, :, -1:], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.sum(level * level[:, :, -1:], axis=1) / span
    return np.where(span > 0.0, along, np.linalg.norm(level, axis=1))
