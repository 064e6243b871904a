"""The scene language as a tree: which keys may stand where, and what a value at a path must be.

Reads the annotations of the models, so that errors, overrides and sweeps know every key without a
second list of them. A position in the tree is a ``Spot``: an annotation and the raw value there
(the value decides between the kinds of a union).
"""

from __future__ import annotations

import types
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from pydantic import Discriminator, Tag
from pydantic_core import PydanticCustomError

from lumpedcable.scene.part import Part, Path
from lumpedcable.scene.quantities import Count, Quantity

Absent: Any = object()
"""The raw value of a key that the scene does not give."""


class Spot(NamedTuple):
    """A place in the scene language: the type wanted there, and the raw value given."""

    annotation: Any
    value: Any = Absent


@cache
def fields(cls: type[Part]) -> dict[str, Any]:
    """Return the annotations of a model's own keys."""
    hints = get_type_hints(cls, include_extras=True)
    return {name: hints[name] for name in cls.model_fields}


def plain(spot: Spot) -> tuple[Any, tuple[Any, ...]]:
    """Return the type of a spot without Optional and Annotated, and its annotations.

    A union is resolved to the kind that the value chooses, or stays where it chooses none.
    """
    annotation, notes = spot.annotation, ()
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *more = get_args(annotation)
            notes += tuple(more)
        elif get_origin(annotation) in (Union, types.UnionType):
            kinds = [kind for kind in get_args(annotation) if kind is not type(None)]
            if len(kinds) == 1:
                annotation = kinds[0]
                continue
            kind = _chosen(kinds, notes, spot.value)
            if kind is None:
                return annotation, notes
            annotation, notes = kind, ()
        else:
            return annotation, notes


def _chosen(kinds: list[Any], notes: tuple[Any, ...], value: Any) -> Any | None:
    discriminator = next((note for note in notes if isinstance(note, Discriminator)), None)
    if discriminator is None or value is Absent:
        return None
    try:
        wanted = discriminator.discriminator(value)  # type: ignore[operator]
    except PydanticCustomError:
        return None
    for kind in kinds:
        if any(isinstance(note, Tag) and note.tag == wanted for note in get_args(kind)[1:]):
            return kind
    return None


def model(spot: Spot) -> type[Part] | None:
    """Return the model of a spot that is a table with fixed keys, else None."""
    annotation, _ = plain(spot)
    return annotation if isinstance(annotation, type) and issubclass(annotation, Part) else None


def step(spot: Spot, key: str | int) -> Spot | None:
    """Return the spot at ``key`` below this one, or None where no such key may stand."""
    annotation, _ = plain(spot)
    below = _value_at(spot.value, key)
    if isinstance(annotation, type) and issubclass(annotation, Part):
        hint = fields(annotation).get(str(key))
        return None if hint is None else Spot(hint, below)
    arguments = get_args(annotation)
    if get_origin(annotation) is dict:
        return Spot(arguments[1], below)
    if get_origin(annotation) is tuple and below is not Absent:
        if arguments[-1] is Ellipsis:
            return Spot(arguments[0], below)
        return Spot(arguments[int(key)], below) if int(key) < len(arguments) else None
    return None


def _value_at(value: Any, key: str | int) -> Any:
    if isinstance(value, dict):
        return value.get(key, Absent)
    word = str(key)
    # a number of an item is written in one way only, "0", not "00", and is no longer than their count
    if (
        isinstance(value, list)
        and len(word) <= len(str(len(value)))
        and word.isdecimal()
        and word == str(int(word))
    ):
        return value[int(word)] if int(word) < len(value) else Absent
    return Absent


def spot_at(root: Spot, path: Path) -> Spot | None:
    """Return the spot at a path, or None where the language has no such path."""
    spot: Spot | None = root
    for key in path:
        spot = step(spot, key)
        if spot is None:
            return None
    return spot


def number_at(root: Spot, path: Path) -> Any:
    """Return the raw value at a path, or the number that its absence stands for; Absent without one."""
    spot, parent = spot_at(root, path), spot_at(root, path[:-1])
    if spot is None or parent is None or parent.value is Absent:
        return Absent
    if spot.value is not Absent:
        return spot.value
    kind = model(parent)
    field = None if kind is None else kind.model_fields.get(str(path[-1]))
    chosen = kind is not None and path[-1] in kind.CHOSEN
    default = None if field is None or chosen else field.default
    return default if isinstance(default, int | float) and not isinstance(default, bool) else Absent


def is_drawn(root: Spot, path: Path) -> bool:
    """Whether nothing that is computed depends on a key."""
    parts = ((path[n], spot_at(root, path[:n])) for n in range(1, len(path)))
    kinds = ((key, spot and model(spot)) for key, spot in parts)
    return any(kind is not None and key in kind.DRAWN for key, kind in kinds)


def numeric(spot: Spot) -> Quantity | Count | None:
    """Return what kind of number a spot holds, or None where it holds something else."""
    _, notes = plain(spot)
    return next((note for note in notes if isinstance(note, Quantity | Count)), None)


def is_open_list(spot: Spot) -> bool:
    """Return whether a spot is a list of any length (not a vector)."""
    return Ellipsis in get_args(plain(spot)[0])


def is_broken(spot: Spot | None) -> bool:
    """Return whether the value given at a spot has not even the shape wanted there."""
    if spot is None or spot.value is Absent:
        return False
    annotation = plain(spot)[0]
    origin = get_origin(annotation)
    if origin in (Union, types.UnionType):
        return True  # no kind of the union fits
    if origin is dict or (isinstance(annotation, type) and issubclass(annotation, Part)):
        return not isinstance(spot.value, dict)
    return origin is tuple and not isinstance(spot.value, list)


def paths(spot: Spot, path: Path = ()) -> Iterator[tuple[Path, bool]]:
    """Yield every path that may be set below a spot, and whether the scene gives it.

    Tables named by the user are entered where they exist; optional tables with fixed keys always.
    """
    if path:
        yield path, spot.value is not Absent
    cls = model(spot)
    if cls is not None:
        for key in fields(cls):
            below = step(spot, key)
            if below is not None:
                yield from paths(below, (*path, key))
    elif isinstance(spot.value, dict):
        for key in spot.value:
            below = step(spot, key)
            if below is not None:
                yield from paths(below, (*path, key))
    elif isinstance(spot.value, list):
        for i in range(len(spot.value)):
            below = step(spot, i)
            if below is not None:
                yield from paths(below, (*path, str(i)))
