"""Which kind of file some tables are, where another kind was expected: told in one line."""

from __future__ import annotations

import os.path
from pathlib import Path as FilePath
from typing import Any

__all__ = ["FIT", "SCENE", "other_kind"]

SCENE, FIT = "a scene", "a fit file"
_OWN = {SCENE: {"materials", "lines", "output"}, FIT: {"scene", "free", "experiments"}}
_ENOUGH = 2  # of its own tables by which a kind is known


def other_kind(file: FilePath, data: dict[str, Any], holds: str) -> str | None:
    """What is said of a file of the other kind, and what to give instead; None where it is none."""
    if _OWN[holds] & data.keys():
        return None
    found = next((kind for kind, own in _OWN.items() if len(own & data.keys()) >= _ENOUGH), None)
    if found == FIT:
        scene = data.get("scene")
        known = isinstance(scene, str)
        named = f" ({os.path.normpath(file.parent / scene)})" if known else ""
        return (
            f"expected {SCENE}, found {FIT}: give its scene{named}, or the fitted one that "
            f"lumpedcable fit {file} writes"
        )
    if found == SCENE:
        return (
            f"expected {FIT}, found {SCENE}: lumpedcable run {file} computes it; a fit file names it "
            f'by scene = "{file.name}", beside [free] and [experiments]'
        )
    return None
