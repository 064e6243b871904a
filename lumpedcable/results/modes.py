"""Natural modes as a JSON file: few numbers, for people and for any other program."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lumpedcable.results.numbers import write_text

__all__ = ["write_modes"]


def write_modes(
    target: Path, head: Mapping[str, Any], parts: Mapping[str, Mapping[str, Any]]
) -> None:
    """Write a file of natural modes, one text line for the long lists of each cable or body.

    Args:
        target: where it goes; its folder is made if it does not exist.
        head: everything short, JSON values.
        parts: by kind of part ("lines", "bodies") and name, a JSON value with its places and shapes.

    Raises:
        OutputError: it cannot be written there.
    """
    # json indents lists item by item, which would make a screen of every vector
    short = json.dumps(dict(head), indent=2, allow_nan=False, ensure_ascii=False)
    sections = []
    for kind, members in parts.items():
        long = [
            f"    {json.dumps(name)}: {json.dumps(value, allow_nan=False)}"
            for name, value in members.items()
        ]
        sections.append(f"  {json.dumps(kind)}: {{\n" + ",\n".join(long) + "\n  }")
    write_text(target, short[:-2] + ",\n" + ",\n".join(sections) + "\n}\n")
