"""What a results file is made of: variables, coordinates, and the names they go by.

The layout is plain HDF5 with dimension scales, which is also what netCDF-4 is, so that xarray,
h5py, Panoply, MATLAB and the HDF5 tools all read it with names and units::

    /time (time) s, /run (run), /xyz (xyz)         dimension scales
    /<axis> (run)                                  one per swept number, attribute `key`
    /status, /status_time, /status_message (run)   how each run ended
    /written (run)                                 number of saved times that have been written
    /field_time (field_time) s                     only where fields are kept more seldom than the rest
    /lines/<name>/...                              (run, time or field_time, node, xyz) and the like
    /bodies/<name>/...                             (run, time, xyz) and (run, time, angle)
    /energy/<term> (run, time)                     J
    /summary/<end>/<quantity> (run)                numbers of one recoiling end
    /summary/<quantity> (run)                      numbers of the whole run
    /rest/<cable>/<quantity> (run)                 numbers of a cable of a scene at rest
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.results.errors import ResultError

SCHEMA_VERSION = "1"
"""Version of the layout written into every file; a reader refuses a larger major number."""

PARTIAL_SUFFIX = ".partial"
"""Appended to the target's name while the file is being written."""

FIELD_TIME = "field_time"
"""The dimension along time of fields that are kept more seldom than what is one number at a time."""

END_SPEED = "peak_end_speed"
"""Name of the peak speed of a recoiling end, for who writes it and who draws it."""

PEAK_TENSION = "peak_tension"
"""Name of the largest tension of each segment of a line, for who writes it and who draws it."""

BREAKING_STRENGTH = "breaking_strength"
"""Name of the strength of a line's material, for who writes it and who draws it."""


def exact_name(quantity: str) -> str:
    """What the exact number beside a number of a recoiling end is called."""
    return f"exact_{quantity}"


RESERVED = frozenset(
    {
        "run",
        "time",
        FIELD_TIME,
        "xyz",
        "angle",
        "bodies",
        "written",
        "status",
        "status_time",
        "status_message",
        "lines",
        "energy",
        "summary",
        "rest",
    }
)
"""Names at the root of the file that a swept number must not take."""

_STRUCTURAL = frozenset({"held", "fixed", "motion", "solver", "output", "statics"})
"""Parts of a key that say where a number stands in the scene, not what it is."""

_VECTORS = frozenset({"fixed", "position", "direction", "velocity", "amplitude"})
"""Keys that hold three components, x, y, z."""


@dataclass(frozen=True)
class Variable:
    """A dataset whose values arrive while the study runs.

    Attributes:
        path: place in the file, e.g. "lines/rope/position".
        dims: names of its dimensions, e.g. ("run", "time", "node", "xyz"). Each is looked up in the
            variable's own group, then in the groups above it up to the root.
        dtype: "f8", "f4", an integer type, or "str" for text.
        units: SI unit, "1" where there is none.
        long_name: what it is, in words.
        attributes: further attributes, such as `flag_values` and `flag_meanings`.
        fill: what unwritten values read as; by default NaN, 0 or "".
        counted: whether a time counts as written only when this is there too; False for what is
            worked out when a run has ended.
        places: whether it tells where the others of its group are, as a coordinate does.
    """

    path: str
    dims: tuple[str, ...]
    dtype: str = "f8"
    units: str = "1"
    long_name: str = ""
    attributes: Mapping[str, Any] = field(default_factory=dict)
    fill: float | int | None = None
    counted: bool = True
    places: bool = False


@dataclass(frozen=True)
class Coordinate:
    """A dataset known before the study runs: times, node places, swept numbers.

    Attributes:
        values: its values, in SI units; numbers or strings.
        units: SI unit, "1" where there is none.
        long_name: what it is, in words.
        dims: names of its dimensions; by default the one dimension it is named after.
        attributes: further attributes, such as `key`.
    """

    values: ArrayLike
    units: str = "1"
    long_name: str = ""
    dims: tuple[str, ...] | None = None
    attributes: Mapping[str, Any] = field(default_factory=dict)


def partial_of(target: Path) -> Path:
    """Where a results file is written until it is whole."""
    return target.with_name(target.name + PARTIAL_SUFFIX)


def check_version(path: Path, version: str) -> None:
    """Refuse a file without a layout version, or with one newer than is known (ResultError)."""
    if not version:
        raise ResultError(f"{path} is HDF5 but not a results file of lumpedcable")
    try:
        major = int(version.split(".")[0])
    except ValueError:
        raise ResultError(f"{path} has the unknown layout version {version!r}") from None
    if major > int(SCHEMA_VERSION):
        raise ResultError(
            f"{path} has layout version {version}, newer than the {SCHEMA_VERSION} known here;"
            " update lumpedcable to read it"
        )


def axis_names(keys: Sequence[str], others: Collection[str] = ()) -> list[str]:
    """Short dataset names for swept keys: the last two parts, more where that is not unique.

    "lines.rope.end.held.pretension" becomes "held_pretension"; two lines swept alike become
    "rope_end_held_pretension" and "tail_end_held_pretension".

    Args:
        keys: full dotted paths, all different.
        others: names that are taken, such as those of measures.

    Returns:
        One name per key, all different and none in `RESERVED` or `others`.

    Raises:
        ValueError: a key is given twice.
    """
    if len(set(keys)) != len(keys):
        raise ValueError(f"swept keys must differ, found {list(keys)}")
    taken = {*RESERVED, *others}
    depth = [2] * len(keys)
    while True:
        names = ["_".join(key.split(".")[-n:]) for key, n in zip(keys, depth, strict=True)]
        clashing = [
            i
            for i, name in enumerate(names)
            if (names.count(name) > 1 or name in taken) and depth[i] < keys[i].count(".") + 1
        ]
        if not clashing:
            break
        for i in clashing:
            depth[i] += 1
    # what the whole key cannot tell apart (a_b.c and a.b_c, or a key that is a reserved word)
    for i, name in enumerate(names):
        while name in taken or name in names[:i]:
            name += "_"
        names[i] = name
    return names


def axis_words(key: str) -> str:
    """The words that stand for a swept key in a label, e.g. "break time" or "pretension"."""
    *parents, last = key.split(".")
    if last.isdecimal():  # a component of a vector, or an item of a list
        vector = parents[-1] in _VECTORS and int(last) < 3
        return f"{parents[-1]} {'xyz'[int(last)] if vector else last}".replace("_", " ")
    parts = key.split(".")[-2:]
    words = [part for part in parts[:-1] if part not in _STRUCTURAL] + parts[-1:]
    return " ".join(words).replace("_", " ")


def axes_words(keys: Sequence[str]) -> list[str]:
    """The words of several swept keys; those that two share begin with what the key belongs to.

    Two ships' "heave amplitude" become "supply heave amplitude" and "receiver heave amplitude".
    """
    words = [axis_words(key) for key in keys]
    owners = [key.split(".")[1] if key.count(".") > 1 else "" for key in keys]
    return [
        f"{owner} {word}".strip() if words.count(word) > 1 else word
        for owner, word in zip(owners, words, strict=True)
    ]


def sweep_coordinates(
    axes: Sequence[tuple[str, str, ArrayLike]], others: Collection[str] = ()
) -> dict[str, Coordinate]:
    """The coordinates along `run` of a sweep, named and labelled.

    Args:
        axes: for every swept key the full dotted path, the SI unit ("" or "1" if none) and the
            value in every run, shape (run,).
        others: names that are taken by other datasets.

    Returns:
        Coordinates by dataset name, in the order of the axes, each with attributes `key` (the path)
        and `axis` (its place in the order, 0 for the slowest).
    """
    keys = [key for key, _, _ in axes]
    names, words = axis_names(keys, others), axes_words(keys)
    return {
        name: Coordinate(
            values=np.asarray(values),
            units=unit or "1",
            long_name=words[place],
            dims=("run",),
            attributes={"key": key, "axis": place},
        )
        for place, (name, (key, unit, values)) in enumerate(zip(names, axes, strict=True))
    }


def attribute(value: Any) -> Any:
    """A value in the form HDF5 and netCDF both hold: text, a number, or an array of numbers.

    Truth becomes 0 or 1 (netCDF has no boolean); mappings and lists of anything but numbers become
    JSON text.
    """
    if isinstance(value, (bool, np.bool_)):
        return np.int8(value)
    if isinstance(value, (str, int, float, np.number)):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        return value
    if isinstance(value, (list, tuple)) and value:
        array = np.asarray(value) if all(_is_number(item) for item in value) else None
        if array is not None:
            return array
    return json.dumps(value, default=str)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def group_of(path: str) -> str:
    """The group a path lies in: "lines/rope" of "lines/rope/node", "" at the root."""
    return path.rpartition("/")[0]


def resolve(dim: str, group: str, known: Mapping[str, Any]) -> str:
    """The path of a dimension named in a group: its own group first, then each above, then root.

    Raises:
        ValueError: no group from here to the root has that dimension.
    """
    while True:
        path = f"{group}/{dim}" if group else dim
        if path in known:
            return path
        if not group:
            raise ValueError(f"no dimension {dim!r}; known: {', '.join(sorted(known))}")
        group = group_of(group)


def as_dataset(values: ArrayLike) -> NDArray[Any]:
    """Values as an array that HDF5 takes: numbers as they are, text as objects."""
    array = np.asarray(values)
    return array.astype(object) if array.dtype.kind in "UO" else array
