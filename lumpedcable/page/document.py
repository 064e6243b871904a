"""The page as one HTML text: the built template with a scene put in."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from lumpedcable.results.numbers import write_text
from lumpedcable.results.target import keep_others

__all__ = ["document", "save"]


def document(head: Mapping[str, Any], block: str = "") -> str:
    """The whole page, which needs nothing from outside.

    Args:
        head: JSON values, what `web/src` calls the head.
        block: the arrays that the head points into, from `Pack.text`.
    """
    template = files("lumpedcable.page").joinpath("page.html").read_text(encoding="utf-8")
    # "</script" would end the script element that the text stands in, "<!--" with "<script" keep it
    # open, and "<!--blob-->" is put in below
    text = json.dumps(_finite(head), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    for spot, value in (
        ("<!--title-->", html.escape(str(head.get("title", "")))),
        ("<!--head-->", text),
        ("<!--blob-->", block),
    ):
        before, _, after = template.partition(spot)
        template = before + value + after
    return template


def _finite(value: Any) -> Any:
    """JSON has no NaN: it becomes null."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and value - value != 0.0:
        return None
    return value


def save(text: str, target: Path) -> None:
    """Write a page, whole or not at all.

    Raises:
        OutputError: it cannot be written there, or another file is there.
    """
    keep_others(target, "page")
    write_text(target, text)
