"""The page as one HTML text: the built template with a scene put in."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from lumpedcable.results.errors import OutputError
from lumpedcable.results.target import keep_others

__all__ = ["document", "save"]


def document(head: Mapping[str, Any], block: str = "") -> str:
    """The whole page, which needs nothing from outside.

    Args:
        head: JSON values, what `web/src` calls the head.
        block: the arrays that the head points into, from `Pack.text`.
    """
    template = files("lumpedcable.page").joinpath("page.html").read_text(encoding="utf-8")
    # "</" would end the script element that the text stands in
    text = json.dumps(_finite(head), ensure_ascii=False, allow_nan=False).replace("</", "<\\/")
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
    partial = target.with_name(target.name + ".partial")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(f"cannot write {target}: {error.strerror or error}") from error
