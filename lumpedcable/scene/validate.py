"""Raw data to a scene, or to everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lumpedcable.scene import checks
from lumpedcable.scene.errors import problems_of
from lumpedcable.scene.part import Path, Problem
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import Spot, fields, spot_at

SECTIONS = ("materials", "lines", "bodies", "measures", "events", "targets")


def read_scene(
    data: dict[str, Any], told: Iterable[Problem] = ()
) -> tuple[Scene | None, list[Problem]]:
    """Return the scene of raw data and no problems, or the problems.

    The parts are read one by one where the whole cannot be, so that mistakes between the readable
    parts are told together with the parts that cannot be read.

    Args:
        data: the scene as TOML tables.
        told: problems known before, which come first and are not told again.
    """
    problems = list(told)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        scene = None
        problems += problems_of(error, Spot(Scene, data))
        problems += checks.problems(_draft(data))
    else:
        problems += checks.problems(checks.Draft.of(scene))
    return (None, _once(problems)) if problems else (scene, [])


def _once(problems: Iterable[Problem]) -> list[Problem]:
    """Return the first problem of each path."""
    first: dict[Path, Problem] = {}
    for problem in problems:
        first.setdefault(problem.path, problem)
    return list(first.values())


@cache
def _adapter(key: str) -> TypeAdapter[Any]:
    """Return the reader of one top-level key, or of one entry of a named section."""
    spot = spot_at(Spot(Scene), (key, "x") if key in SECTIONS else (key,))
    assert spot is not None
    return TypeAdapter(spot.annotation)


def _read(key: str, raw: Any) -> Any | None:
    try:
        return _adapter(key).validate_python(raw)
    except ValidationError:
        return None


def _draft(data: dict[str, Any]) -> checks.Draft:
    entries = {}
    for section in SECTIONS:
        table = data.get(section, {})
        # A section that is no table at all was told already; its names count as unknown to us.
        entries[section] = (
            {name: _read(section, raw) for name, raw in table.items()}
            if isinstance(table, dict)
            else _Anything()
        )
    singles = {
        key: _read(key, data[key]) for key in fields(Scene) if key in data and key not in SECTIONS
    }
    return checks.Draft(
        **entries,
        others={key: value for key, value in singles.items() if value is not None},
        named=frozenset(singles),
    )


class _Anything(dict[str, None]):
    """A section that could not be read: every name may be in it."""

    def __contains__(self, key: object) -> bool:
        return True

    def __missing__(self, key: str) -> None:
        return None

    def __bool__(self) -> bool:
        return True
