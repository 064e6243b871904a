"""A scene as TOML text in SI numbers, for the record of a run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from lumpedcable.scene.part import Part
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.sweep import Axis


def to_toml(scene: Scene, axes: Sequence[Axis] = ()) -> str:
    """Return a TOML text that reads back as the same scene and sweep.

    Only what was given is written, defaults are not; lists from files are written out, so that the
    text stands alone.
    """
    blocks = ["\n".join(f"{key} = {text}" for key, text in _singles(scene))]
    blocks += ["\n".join([f"[{name}]", *_pairs(table)]) for name, table in _tables(scene)]
    if axes:
        lines = [f"{_text(axis.key)} = {_value(axis.values)}" for axis in axes]
        blocks.append("\n".join(["[sweep]", *lines]))
    return "\n\n".join(block for block in blocks if block) + "\n"


def _given(part: Part) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a part that were given, but for names of files (their data are there)."""
    for name in type(part).model_fields:
        value = getattr(part, name)
        if name in part.model_fields_set and value is not None and name not in part.FILE[:1]:
            yield name, value


def _singles(scene: Scene) -> Iterator[tuple[str, str]]:
    for key, value in _given(scene):
        if not isinstance(value, Part | dict):
            yield key, _value(value)


def _tables(scene: Scene) -> Iterator[tuple[str, Part]]:
    for key, value in _given(scene):
        if isinstance(value, Part):
            yield key, value
        elif isinstance(value, dict):
            yield from ((f"{key}.{name}", entry) for name, entry in value.items())


def _pairs(part: Part) -> list[str]:
    return [f"{key} = {_value(value)}" for key, value in _given(part)]


def _value(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case float() | int():
            return repr(value)
        case str():
            return _text(value)
        case tuple():
            return f"[{', '.join(map(_value, value))}]"
        case Part():
            return f"{{ {', '.join(_pairs(value))} }}"
        case dict():
            return f"{{ {', '.join(f'{key} = {_value(item)}' for key, item in value.items())} }}"
        case _:
            raise TypeError(f"a scene holds no {type(value).__name__}")


def _text(text: str) -> str:
    # TOML's escapes are JSON's; it asks to escape one character more.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
