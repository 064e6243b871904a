"""Natural modes as a JSON file: few numbers, for people and for any other program."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lumpedcable.results.errors import OutputError

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
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise OutputError(f"cannot write {target}: {reason}") from error
