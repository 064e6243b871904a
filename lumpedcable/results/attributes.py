"""Attributes of HDF5 objects as plain Python values."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

__all__ = ["attributes_of", "text_of"]


def text_of(value: Any) -> str:
    """Text, whether HDF5 holds it as text or as bytes."""
    return value.decode() if isinstance(value, bytes) else str(value)


def attributes_of(item: Any) -> dict[str, Any]:
    """The attributes of a dataset, group or file, without those of HDF5's own book-keeping."""
    hidden = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"}
    found: dict[str, Any] = {}
    for name, value in item.attrs.items():
        if name in hidden:
            continue
        if isinstance(value, (bytes, str)):
            value = text_of(value)
            if name in {"versions", "overrides", "dimensions"}:
                value = _from_json(name, value)
        elif isinstance(value, np.generic):
            value = value.item()
        found[name] = value
    return found


def _from_json(name: str, text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError as error:
        raise ValueError(f"its attribute {name} is no JSON: {error}") from error
