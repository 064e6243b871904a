"""Results that are few numbers, as a JSON file: for people and for any other program."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lumpedcable.results.disk import reported
from lumpedcable.results.target import whole

__all__ = ["write_numbers", "write_text"]


def write_numbers(target: Path, contents: Mapping[str, Any]) -> None:
    """Write tables of numbers as JSON, every list of numbers on one line.

    Args:
        target: where it goes; its folder is made if it does not exist.
        contents: JSON values; arrays become lists, and what is not finite null.

    Raises:
        OutputError: it cannot be written there.
    """
    write_text(target, _text(dict(contents), "") + "\n")


def write_text(target: Path, text: str) -> None:
    """Write a text file, whole or not at all, its folder made if it does not exist.

    Raises:
        OutputError: it cannot be written there.
    """
    with reported(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with whole(target) as partial:
            partial.write_text(text, encoding="utf-8")


def _text(value: Any, indent: str) -> str:
    value = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    deeper = indent + "  "
    if isinstance(value, Mapping) and value:
        rows = [f"{deeper}{json.dumps(str(k))}: {_text(v, deeper)}" for k, v in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    if isinstance(value, list | tuple) and any(isinstance(v, Mapping) for v in value):
        rows = [deeper + _text(v, deeper) for v in value]
        return "[\n" + ",\n".join(rows) + f"\n{indent}]"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_text(v, deeper) for v in value)}]"
    if isinstance(value, float) and not math.isfinite(value):
        return "null"
    return json.dumps(value, ensure_ascii=False)
