"""Free numbers: which they are, where they begin, and the bounds that they stay within."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from pydantic_core import PydanticCustomError

from lumpedcable.fitting.language import Free
from lumpedcable.scene import Scene, Study, TanhMaterial, format_quantity
from lumpedcable.scene.labels import label_of
from lumpedcable.scene.part import Path, Problem
from lumpedcable.scene.quantities import Count, Quantity
from lumpedcable.scene.sweep import swept_number
from lumpedcable.scene.tree import Absent, Spot, is_open_list, numeric, spot_at

__all__ = ["Number", "Parameter", "User", "numbers_of", "read_parameters", "relaxes"]

_NOT_PHYSICS = ("solver", "statics")

UNTIMED = ", which a bench's table tells where it has a column of times: time = { column = ... }"
IN_A_FILE = "data of a CSV file cannot be free: write them out"


@dataclass(frozen=True)
class Parameter:
    """One value to be found: a key of the scene, for all experiments or for one of them."""

    key: str
    """Dotted path in the scene."""
    experiment: str | None
    """The experiment that it belongs to; None for all."""
    unit: str
    """SI unit."""
    label: str
    """Short name for people: "nylon p1"."""
    start: float
    """Where the search begins (SI)."""
    low: float
    """Lower bound (SI), -inf for none."""
    high: float
    """Upper bound (SI), inf for none."""
    profile: bool | None = None
    """Whether its profile is wanted; None where the data hardly tell it."""

    @property
    def name(self) -> str:
        """The key, with the experiment where it has one."""
        return self.key if self.experiment is None else f"{self.key} [{self.experiment}]"

    @property
    def spread(self) -> bool:
        """Whether it may lie decades from its start: the time within which something relaxes."""
        return relaxes(self.key) and self.key.endswith(".time")


@dataclass(frozen=True)
class Number:
    """A number of a scene that may be freed."""

    key: str
    kind: Quantity
    label: str
    value: float
    sided: bool
    """It keeps the sign of its start: with the other, the scene has a twin that is the same."""


class User(NamedTuple):
    """An experiment, and what it may depend on.

    `material` is a bench's, "" of a record, which may depend on any number of its scene but a law's
    range. `timed`: whether the bench tells when its tensions were measured.
    """

    name: str
    study: Study
    material: str = ""
    timed: bool = False


def numbers_of(study: Study, key: str) -> tuple[list[Number], str]:
    """The numbers of a scene that a key means (several for a list), or what is wrong with it."""
    raw = tomllib.loads(study.effective_text)
    raw.pop("sweep", None)
    root, given = Spot(Scene, raw), study.scene.numbers()
    path = tuple(key.split("."))
    if path[0] in _NOT_PHYSICS:
        return [], f'expected a number of the physics, found "{key}", which is one of the method'
    spot = spot_at(root, path)
    keys = [key]
    if spot is not None and isinstance(spot.value, list) and is_open_list(spot):
        keys = [f"{key}.{i}" for i in range(len(spot.value))]
    numbers = []
    for one in keys:
        kind, message = swept_number(root, one)
        if kind is None:
            return [], message or f'expected a number of the scene, found "{one}"'
        if isinstance(kind, Count) or not isinstance(
            numeric(spot_at(root, tuple(one.split("."))) or root), Quantity
        ):
            return [], f'expected a number that varies smoothly, found "{one}", a whole number'
        here = spot_at(root, tuple(one.split(".")))
        if one not in given and here is not None and here.value is not Absent:
            if _from_file(study.scene, one):
                return [], f'expected a number of the scene file, found "{one}", {IN_A_FILE}'
            return (
                [],
                f'expected a number that moves something, found "{one}", which runs are judged by',
            )
        if one not in given:
            return [], (
                f'expected a number that the scene gives, found "{one}", which it does not: '
                f"write a value there{f' ({IN_A_FILE})' if _from_file(study.scene, one) else ''}"
            )
        numbers.append(Number(one, kind, label_of(root, one), given[one], _sided(study, one)))
    return numbers, ""


def _from_file(scene: Scene, key: str) -> bool:
    """Whether a number is of a part that names a file, which it may come from."""
    part: Any = scene
    for name in key.split(".")[:-1]:
        part = part.get(name) if isinstance(part, Mapping) else getattr(part, name, None)
        if getattr(part, "file", None):
            return True
    return False


def _sided(study: Study, key: str) -> bool:
    """Whether a number is p2 of a tanh law, which stays as it is when p1, p2 and p3 turn their signs."""
    place, _, rest = key.partition(".")
    name, _, last = rest.partition(".")
    return (
        place == "materials" and last == "p2"
        and isinstance(study.scene.materials.get(name), TanhMaterial)
    )  # fmt: skip


def read_parameters(
    free: Mapping[str, Free], experiments: Sequence[User], at: Path
) -> tuple[list[Parameter], list[Problem]]:
    """The parameters of a fit.

    Args:
        free: free numbers by key, as in the file.
        experiments: all of them, with what they may depend on.
        at: where `free` stands in the file.
    """
    parameters: list[Parameter] = []
    problems: list[Problem] = []
    for key, one in free.items():
        users, message = [], ""
        for user in experiments:
            numbers, wrong = numbers_of(user.study, key)
            message = message or wrong
            if numbers and _depends(key, user):
                users.append((user.name, numbers))
        if not users:
            said = message or f'expected a number that an experiment depends on, found "{key}"'
            said += "" if message or not relaxes(key) else UNTIMED
            problems.append(Problem((*at, key), said))
            continue
        if not one.private and (wrong := _apart(key, users, at)) is not None:
            problems.append(wrong)
            continue
        owners = users if one.private else [("", users[0][1])]
        for name, numbers in owners:
            for number in numbers:
                made, wrong = _parameter(number, one, name or None, (*at, key))
                problems += wrong
                parameters += [made] if made else []
    problems += _twice(parameters, at)
    return _distinct(parameters), list(dict.fromkeys(problems))


def _apart(key: str, users: Sequence[tuple[str, list[Number]]], at: Path) -> Problem | None:
    """A number that is found for all experiments and that some of them give a value of their own."""
    (first, given), *others = users
    for name, own in others:
        if [(n.key, n.value) for n in own] != [(n.key, n.value) for n in given]:
            return Problem(
                (*at, key),
                f'expected one value of "{key}" to begin with, found one in "{first}" and another in '
                f'"{name}": what is found for all has no value of its own in [set] of an experiment; '
                "private = true finds one for each",
            )
    return None


def _depends(key: str, user: User) -> bool:
    """Whether an experiment depends on a number: a bench on the law of its material alone.

    On what relaxes beside the law as well where it tells the times of its rows. A law's range bounds
    the step of a run and moves nothing.
    """
    last = key.rpartition(".")[2]
    if key.startswith("materials.") and last == "max_strain":
        return False
    if not user.material:
        return True
    mine = key.startswith(f"materials.{user.material}.") and last != "damping"
    return mine and (user.timed or not relaxes(key))


def relaxes(key: str) -> bool:
    """Whether a number is of a branch of a material: materials.NAME.relaxation.BRANCH.EA."""
    section, *rest = key.split(".")
    return section == "materials" and rest[1:2] == ["relaxation"]


def _parameter(
    number: Number, free: Free, experiment: str | None, path: Path
) -> tuple[Parameter | None, list[Problem]]:
    problems: list[Problem] = []

    def read(key: str, default: float, kind: Quantity) -> float:
        raw = getattr(free, key)
        if raw is None:
            return default
        try:
            return kind.read(raw)
        except PydanticCustomError as error:
            problems.append(Problem((*path, key), error.message()))
            return default

    positive = number.kind.sign != "any"
    start = read("start", number.value, number.kind)
    above, below = positive or (number.sided and start > 0.0), number.sided and start < 0.0
    # a bound on the wrong side would let the search leave what the scene allows
    lowest = Quantity(
        number.kind.unit, "nonnegative" if positive else "any", words=number.kind.words
    )
    low = read("low", 0.0 if above else -math.inf, lowest)
    highest = math.inf if number.kind.maximum is None else number.kind.maximum
    highest = 0.0 if below else highest
    high = read("high", highest, replace(number.kind, sign="any"))
    if not problems and low >= high:
        problems += _crossed(number, free, low, high, path)
    elif not problems and not low < start < high:
        between = " and ".join(
            format_quantity(bound, number.kind.unit) if math.isfinite(bound) else "no bound"
            for bound in (low, high)
        )
        key = "start" if free.start is not None else "low" if free.low is not None else "high"
        problems.append(
            Problem(
                (*path, key),
                f"expected a start between the bounds {between}, found "
                f"{format_quantity(start, number.kind.unit)}",
            )
        )
    if problems:
        return None, problems
    kind = number.kind
    return (
        Parameter(
            number.key, experiment, kind.unit, number.label, start, low, high, free.profile
        ),
        [],
    )  # fmt: skip


def _crossed(number: Number, free: Free, low: float, high: float, path: Path) -> list[Problem]:
    """What is wrong with bounds that leave nothing between them."""
    least, most = (format_quantity(bound, number.kind.unit) for bound in (low, high))
    if free.high is None:
        return [Problem((*path, "low"), f"expected low below {most}, found {least}")]
    own = f"low = {least}" if free.low is not None else least
    return [Problem((*path, "high"), f"expected high above {own}, found {most}")]


def _twice(parameters: Sequence[Parameter], at: Path) -> list[Problem]:
    names = [parameter.name for parameter in parameters]
    return [
        Problem((*at, name), f'expected each number once, found "{name}" again')
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]


def _distinct(parameters: Sequence[Parameter]) -> list[Parameter]:
    """The parameters with labels that tell them apart."""
    shorts = [(p.label, p.experiment) for p in parameters]
    found = []
    for p in parameters:
        label = p.label if shorts.count((p.label, p.experiment)) == 1 else p.key
        label = label if p.experiment is None else f"{label} [{p.experiment}]"
        found.append(replace(p, label=label))
    return found
