"""Natural modes as a JSON file: few numbers, for people and for any other program."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lumpedcable.results.numbers import write_text

__all__ = ["write_modes"]


def write_modes(target: Path, head: Mapping[str, Any], lines: Mapping[str, Any]) -> None:
    """Write a file of natural modes, one text line for the long lists of each cable.

    Args:
        target: where it goes; its folder is made if it does not exist.
        head: everything short, JSON values.
        lines: by line, a JSON value with its places and shapes.

    Raises:
        OutputError: it cannot be written there.
    """
    # json indents lists item by item, which would make a screen of every vector
    short = json.dumps(dict(head), indent=2, allow_nan=False, ensure_ascii=False)
    long = [
        f"    {json.dumps(name)}: {json.dumps(value, allow_nan=False)}"
        for name, value in lines.items()
    ]
    text = short[:-2] + ',\n  "lines": {\n' + ",\n".join(long) + "\n  }\n}\n"
    write_text(target, text)
