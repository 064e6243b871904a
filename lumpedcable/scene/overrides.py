"""Changes to a scene from outside its file: "KEY=VALUE" texts, as the command line takes them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, get_origin

from lumpedcable.scene.entries import SETTINGS, Entry, is_spec
from lumpedcable.scene.errors import Fault
from lumpedcable.scene.events import SHORT, with_place
from lumpedcable.scene.part import Path, dotted
from lumpedcable.scene.quantities import found
from lumpedcable.scene.runs import with_values
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import Absent, Spot, numeric, paths, plain, spot_at
from lumpedcable.scene.units import nearest

_SHOWN = 6  # candidates listed for an ambiguous key


@dataclass
class Overridden:
    """Raw data after overrides, and what each of them changed."""

    data: dict[str, Any]
    """The scene as TOML tables, without its sweep."""
    sweep: list[Entry]
    """The factors of its sweep as they were written."""
    origins: dict[Path, str] = field(default_factory=dict)
    """The override behind a path."""
    faults: list[Fault] = field(default_factory=list)
    """Overrides that could not be understood."""


def apply(overrides: Iterable[str], data: dict[str, Any], sweep: Iterable[Entry]) -> Overridden:
    """Return the data with every override applied, in order.

    A list or a range for a key that holds one number makes that key an axis of the sweep; one value
    for a swept key takes its axis away.
    """
    result = Overridden(data, list(sweep))
    for text in overrides:
        key, equals, value_text = text.partition("=")
        key = key.strip()
        if not equals or not key or not value_text.strip():
            message = f"expected KEY=VALUE, found {found(text)}"
            result.faults.append(Fault("", None, "", message, text))
            continue
        value = read_value(value_text)
        if _set_draws(result, text, key, value):
            continue
        path, message = resolve(key, value, result.data)
        if path is None:
            result.faults.append(Fault("", None, "", message, text))
            continue
        if not isinstance(value, str) and _is_text(spot_at(Spot(Scene, result.data), path)):
            value = value_text.strip()  # a title "12" is no number
        _set(result, text, path, value)
    return result


def _set_draws(result: Overridden, text: str, key: str, value: Any) -> bool:
    """Set how many draws there are, or how they are drawn: "sweep.sample.count"; whether it was that."""
    where, _, setting = key.rpartition(".")
    if setting not in SETTINGS["sample"]:
        return False
    samples = sum(entry.kind == "sample" for entry in result.sweep)
    for k, entry in enumerate(result.sweep):
        named = where == dotted(entry.place) or (samples == 1 and where == "sweep.sample")
        if entry.kind == "sample" and named:
            result.sweep[k] = replace(entry, settings=entry.settings | {setting: value})
            result.origins[*entry.place, setting] = text
            return True
    return False


def _is_text(spot: Spot | None) -> bool:
    """Whether a text stands there and nothing else could."""
    return spot is not None and plain(Spot(spot.annotation))[0] is str


def _set(result: Overridden, text: str, path: Path, value: Any) -> None:
    key = dotted(path)
    result.data = with_place(result.data, path)
    spot = spot_at(Spot(Scene, result.data), path)
    if (isinstance(value, list) or is_spec(value)) and spot is not None and numeric(spot):
        place: Path = ("sweep", key)
        entry = Entry("list", place, {key: (place, value)})
        same = [i for i, e in enumerate(result.sweep) if e.kind == "list" and key in e.keys]
        if same:
            result.sweep[same[0]] = entry
        else:
            singles = sum(e.kind == "list" for e in result.sweep)
            rest = _without(result.sweep, key)
            result.sweep = [*rest[:singles], entry, *rest[singles:]]
        result.origins[place] = text
        return
    result.sweep = _without(result.sweep, key)
    if len(path) == 3 and path[2] in SHORT.get(str(path[0]), ()) and "@" in str(value):
        # "rope@37.5 m" says the place as well
        place = (*path[:2], "place")
        result.sweep = _without(result.sweep, dotted(place))
        own = result.data.get(str(path[0]), {}).get(path[1], {})
        entry = {k: v for k, v in own.items() if k != "place"}
        result.data = with_values(result.data, {path[:2]: entry})
    result.data = with_values(result.data, {path: value})
    # A later override of the same value, or of a table around it, is the one to blame.
    for older in [p for p in result.origins if p[: len(path)] == path]:
        del result.origins[older]
    result.origins[path] = text


def _without(sweep: list[Entry], key: str) -> list[Entry]:
    """Return a sweep in which nothing moves a key or what is below it."""
    left = [entry.without(key) for entry in sweep]
    return [entry for entry in left if entry.keys]


def read_value(text: str) -> Any:
    """Return the TOML value of a text, or the text itself where it is none ("50 ms").

    Texts inside a flat list need no quotes either: [45 kN, 90 kN].
    """
    text = text.strip()
    try:
        table = tomllib.loads(f"value = {text}")
        if len(table) == 1:  # else another line follows the value, which is no part of it
            return table["value"]
    except (ValueError, KeyError, RecursionError):
        pass
    if text.startswith("[") and text.endswith("]") and not any(c in text[1:-1] for c in "[]{}\"'"):
        items = [item.strip() for item in text[1:-1].split(",")]
        # a comma may end a list, as in TOML; what is missing elsewhere is told where it is read
        return [read_value(item) for item in (items if items[-1] else items[:-1])]
    return text


def resolve(key: str, value: Any, data: dict[str, Any]) -> tuple[Path | None, str]:
    """Return the path that a key means, or None and what is wrong with it.

    A key is a full path, or the end of one: "break.time" for events.break.time. Of several paths
    with that end, one that the scene gives is meant before one that it could give, and a key of a
    table that the scene gives before the others.
    """
    wanted = tuple(key.split("."))
    if wanted[0] == "sweep":
        return None, (
            f'expected the path of the number itself, found "{key}"; '
            "a list of values makes it an axis of the sweep, and of draws sweep.sample.count, seed and "
            "method can be set"
        )
    known = {
        tuple(map(str, path)): given
        for path, given in paths(Spot(Scene, data))
        if path[0] != "references"
    }
    if wanted in known:
        return wanted, ""
    if _is_entry(wanted, value, data):
        return wanted, ""
    ends = [path for path in known if path[-len(wanted) :] == wanted]
    matches = (
        [path for path in ends if known[path]]
        or [path for path in ends if known.get(path[:-1], True)]
        or ends
    )
    if len(matches) == 1:
        return matches[0], ""
    if matches:
        listed = ", ".join(dotted(path) for path in matches[:_SHOWN])
        more = f" and {len(matches) - _SHOWN} more" if len(matches) > _SHOWN else ""
        return None, f'expected the path of one value, found "{key}" in {listed}{more}'
    tails = {dotted(path[-n:]): path for path in known for n in range(1, len(path) + 1)}
    guess = nearest(key, tails)
    hint = f'; did you mean "{dotted(tails[guess])}"?' if guess else ""
    return None, f'expected the path of a value, found "{key}"{hint}'


def _is_entry(wanted: Path, value: Any, data: dict[str, Any]) -> bool:
    """Whether a path is a new entry of a named section, or of names in a part that the scene gives.

    As a branch of a material, or a point of a body; of a section it is given as a whole.
    """
    root = Spot(Scene, data)
    if len(wanted) == 2:
        return isinstance(value, dict) and spot_at(root, wanted) is not None
    owner, names = spot_at(root, wanted[:-2]), spot_at(root, wanted[:-1])
    if owner is None or owner.value is Absent or names is None or wanted[0] == "references":
        return False
    return get_origin(plain(names)[0]) is dict
