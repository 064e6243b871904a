"""A scene as TOML text in SI numbers, for the record of a run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from lumpedcable.scene.part import Part
from lumpedcable.scene.runs import Factor
from lumpedcable.scene.scene import Scene


def to_toml(scene: Scene, factors: Sequence[Factor] = ()) -> str:
    """Return a TOML text that reads back as the same scene and sweep.

    Only what was given is written, defaults are not; lists from files are written out, so that the
    text stands alone.
    """
    blocks = ["\n".join(f"{key} = {text}" for key, text in _singles(scene))]
    blocks += ["\n".join([f"[{name}]", *_pairs(table)]) for name, table in _tables(scene)]
    singles = [factor.axes[0] for factor in factors if factor.kind == "list"]
    if singles:
        lines = [f"{_text(axis.key)} = {value_text(axis.values)}" for axis in singles]
        blocks.append("\n".join(["[sweep]", *lines]))
    blocks += [block for factor in factors for block in _group(factor)]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _group(factor: Factor) -> Iterator[str]:
    """Yield the tables of a factor of several keys."""
    if factor.kind == "cases":
        for row in range(len(factor)):
            name = [f"name = {_text(factor.names[row])}"] if factor.names else []
            own = [f"{_text(axis.key)} = {value_text(axis.values[row])}" for axis in factor.axes]
            yield "\n".join(["[[sweep.cases]]", *name, *own])
    elif factor.kind == "zip":
        lines = [f"{_text(axis.key)} = {value_text(axis.values)}" for axis in factor.axes]
        yield "\n".join(["[[sweep.zip]]", *lines])
    elif factor.kind == "sample":
        lines = [f"{_text(key)} = {value_text(value)}" for key, value in factor.drawn.items()]
        yield "\n".join(["[[sweep.sample]]", *lines])


def _given(part: Part) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a part that were given, but for names of files (their data are there)."""
    for name in type(part).model_fields:
        value = getattr(part, name)
        if name in part.model_fields_set and value is not None and name not in part.FILE[:1]:
            yield name, value


def _singles(scene: Scene) -> Iterator[tuple[str, str]]:
    for key, value in _given(scene):
        if not isinstance(value, Part | dict):
            yield key, value_text(value)


def _tables(scene: Scene) -> Iterator[tuple[str, Part]]:
    for key, value in _given(scene):
        if isinstance(value, Part):
            yield key, value
        elif isinstance(value, dict):
            yield from ((f"{key}.{name}", entry) for name, entry in value.items())


def _pairs(part: Part) -> list[str]:
    return [f"{key} = {value_text(value)}" for key, value in _given(part)]


def value_text(value: Any) -> str:
    """Return a value as it stands in TOML."""
    match value:
        case bool():
            return str(value).lower()
        case float() | int():
            return repr(value)
        case str():
            return _text(value)
        case tuple() | list():
            return f"[{', '.join(map(value_text, value))}]"
        case Part():
            return f"{{ {', '.join(_pairs(value))} }}"
        case dict():
            return (
                f"{{ {', '.join(f'{key} = {value_text(item)}' for key, item in value.items())} }}"
            )
        case _:
            raise TypeError(f"a scene holds no {type(value).__name__}")


def _text(text: str) -> str:
    # TOML's escapes are JSON's; it asks to escape one character more.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
