"""Reading a fit file: one call from a path to a problem, or to every fault in file and data."""

from __future__ import annotations

import glob
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from lumpedcable.fitting.checks import (
    bench_problems,
    length_problems,
    smooth_tables,
    uncovered_problems,
    unknown_start,
    whole_problems,
)
from lumpedcable.fitting.columns import check_history, check_times, noise_of, read_data
from lumpedcable.fitting.data import FitProblem, Record, Series, Table
from lumpedcable.fitting.language import (
    Choice,
    Column,
    FitFile,
    Free,
    RecordExperiment,
    Sampling,
    TableExperiment,
)
from lumpedcable.fitting.observe import UNITS, watched
from lumpedcable.fitting.parameters import User, numbers_of, read_parameters
from lumpedcable.model.layout import make_layout
from lumpedcable.scene import Fault, SceneError, Study, load_study
from lumpedcable.scene.checks import inside
from lumpedcable.scene.errors import problems_of
from lumpedcable.scene.kinds import FIT
from lumpedcable.scene.load import read_toml
from lumpedcable.scene.locate import LineMap
from lumpedcable.scene.overrides import resolve
from lumpedcable.scene.part import Path, Problem, did_you_mean, dotted
from lumpedcable.scene.tree import Spot
from lumpedcable.scene.units import format_quantity
from lumpedcable.scene.writer import value_text

__all__ = ["FitStudy", "load_fit"]

ROPE = "{rope}"
"""What stands for a rope's name in the name of a file."""
SIGNED = 0.1  # of its largest value: data that are as far below 0 are no sizes
_LETTERS = "names that files can have, without / and \\"
_ROPE_NAME = re.compile(r"[^/\\.][^/\\]*")


class FitStudy(NamedTuple):
    """A fit file as read: the problem, and the same data with other laws by name.

    Where it names ropes, the problem of each; `problem` is then that of the first.
    """

    path: FilePath
    problem: FitProblem
    choices: dict[str, FitProblem]
    ropes: dict[str, FitProblem]
    sampling: Sampling | None


def load_fit(path: FilePath) -> FitStudy:
    """Read a fit file, its scene and its data.

    Raises:
        SceneError: with every fault found.
    """
    text, data = read_toml(path, FIT)
    reader = _Reader(path, text)
    try:
        file = FitFile.model_validate(data)
    except ValidationError as error:
        reader.tell(problems_of(error, Spot(FitFile, data)))
        raise SceneError(reader.faults) from None
    reader.tell(inside(file, ()))
    reader.stop()
    if (names := reader.ropes(file)) is not None:
        ropes = {name: reader.problem(of_rope(file, name), file.free, ("free",)) for name in names}
        reader.stop()
        good = {name: problem for name, problem in ropes.items() if problem is not None}
        return FitStudy(path, next(iter(good.values())), {}, good, None)
    main = reader.problem(file, file.free, ("free",))
    choices = {
        name: reader.problem(file, choice.free, ("choices", name, "free"), choice)
        for name, choice in file.choices.items()
    }
    drawn = main if file.sample is not None else None
    if drawn is not None and not drawn.known_noise and drawn.points <= len(drawn.parameters):
        found = f"{drawn.points} values of unknown noise for {len(drawn.parameters)} numbers"
        reader.tell([Problem(("sample",), f"expected more values than numbers, found {found}")])
    reader.stop()
    assert main is not None
    return FitStudy(
        path, main, {name: p for name, p in choices.items() if p is not None}, {}, file.sample
    )


def of_rope(file: FitFile, rope: str) -> FitFile:
    """The same file for one of its ropes."""
    mine = {
        name: one.model_copy(update={"file": one.file.replace(ROPE, rope)})
        for name, one in file.experiments.items()
    }
    return file.model_copy(update={"experiments": mine})


def _inherited(
    file: FitFile, choice: Choice, base: Study, studies: Iterable[Study]
) -> dict[str, Free]:
    """The numbers of [free] that stay free in a choice: those that its scene, or a record's, has.

    Not those that the choice gives a value, or frees in its own way.
    """
    data = tomllib.loads(base.effective_text)
    paths = [resolve(key, value, data)[0] for key, value in choice.set.items()]
    given = {dotted(path) for path in paths if path is not None}
    every, kept = (base, *studies), {}
    for key, one in file.free.items():
        numbers = next(filter(None, (numbers_of(study, key)[0] for study in every)), [])
        mine = [
            n.key
            for n in numbers
            if not {key, n.key} & given
            and not any(n.key == o or n.key.startswith(f"{o}.") for o in choice.free)
        ]
        kept |= {key: one} if len(mine) == len(numbers) > 0 else dict.fromkeys(mine, one)
    return kept


class _Reader:
    """The faults of one file, gathered while it is read."""

    def __init__(self, path: FilePath, text: str):
        self.path, self.folder, self.map = path, path.parent, LineMap(text)
        self.faults: list[Fault] = []
        self.scenes: dict[tuple[FilePath, tuple[str, ...]], Study | None] = {}

    def tell(self, problems) -> None:
        for problem in problems:
            place = tuple(str(key) for key in problem.path)
            fault = Fault(str(self.path), self.map.line(place), dotted(place), problem.message)
            if fault not in self.faults:  # of every rope and choice the same
                self.faults.append(fault)

    def stop(self) -> None:
        if self.faults:
            raise SceneError(self.faults)

    # --- ropes ------------------------------------------------------------------------------

    def ropes(self, file: FitFile) -> list[str] | None:
        """The names of the ropes, None without any; stops where they are faulty."""
        named = {n: e.file for n, e in file.experiments.items() if ROPE in e.file}
        if file.ropes is None:
            for name in named:
                message = (
                    f'expected ropes = ["NAME", ...] for the "{ROPE}" in this name, found none'
                )
                self.tell([Problem(("experiments", name, "file"), message)])
            self.stop()
            return None
        if not named:
            message = f'expected "{ROPE}" in the file of an experiment, found it in none'
            self.tell([Problem(("ropes",), message)])
        for key in ("choices", "sample"):
            if getattr(file, key):
                message = (
                    f"expected no {key} where there are ropes: it is done for one rope at a time"
                )
                self.tell([Problem((key,), message)])
        self.stop()
        if file.ropes != "*":
            for name in file.ropes:
                if _ROPE_NAME.fullmatch(name) is None or file.ropes.count(name) > 1:
                    twice = "each rope once" if file.ropes.count(name) > 1 else _LETTERS
                    self.tell([Problem(("ropes",), f'expected {twice}, found "{name}"')])
            self.stop()
            return list(file.ropes)
        found = [self._found(pattern) for pattern in named.values()]
        common = sorted(set.intersection(*found))
        if not common:
            message = f"expected files like {next(iter(named.values()))}, found none"
            self.tell([Problem(("ropes",), message)])
        self.stop()
        return common

    def _found(self, pattern: str) -> set[str]:
        """The ropes that there is a file of."""
        before, _, rest = pattern.partition(ROPE)
        shape = re.compile(
            re.escape(before) + r"([^/]+)" + re.escape(rest).replace(re.escape(ROPE), r"\1")
        )
        paths = glob.glob("*".join(map(glob.escape, pattern.split(ROPE))), root_dir=self.folder)
        return {match.group(1) for p in paths if (match := shape.fullmatch(p))}

    # --- scenes -----------------------------------------------------------------------------

    def scene(self, name: str, at: Path, settings: list[tuple[Path, Mapping[str, Any]]]):
        """The study of a scene with settings, None where it is faulty; told once."""
        origin = {}
        for path, values in settings:
            for key, value in values.items():
                text = value if isinstance(value, str) else value_text(value)
                origin[f"{key}={text}"] = (*path, key)
        found = (self.folder / name, tuple(origin))
        if found not in self.scenes:
            self.scenes[found] = self._load(*found, origin, at)
        return self.scenes[found]

    def _load(self, file: FilePath, overrides, origin: dict[str, Path], at: Path) -> Study | None:
        if not file.exists():
            siblings = [p.name for p in file.parent.glob("*.toml")] if file.parent.is_dir() else []
            hint = did_you_mean(file.name, siblings)
            self.tell([Problem(at, f'expected a scene file, found none at "{file}"{hint}')])
            return None
        if file.is_dir():  # as of an empty name
            self.tell([Problem(at, f'expected a scene file, found the folder "{file}"')])
            return None
        try:
            return load_study(file, overrides)
        except SceneError as error:
            for fault in error.faults:
                place = None if fault.override is None else origin.get(fault.override)
                if place is None:
                    self.faults.append(fault)
                else:
                    said = f"{fault.key}: {fault.message}" if fault.key else fault.message
                    self.tell([Problem(place, said)])
        return None

    # --- experiments ------------------------------------------------------------------------

    def problem(
        self, file: FitFile, free: Mapping[str, Free], at: Path, choice: Choice | None = None
    ) -> FitProblem | None:
        """The problem of the file with these free numbers, of a choice with those it inherits."""
        common: list[tuple[Path, Mapping[str, Any]]] = [(("set",), file.set)]
        if choice is not None:
            common.append(((*at[:-1], "set"), choice.set))
        base = self.scene(file.scene, ("scene",), common)
        tables, records = [], []
        for name, one in file.experiments.items():
            path: Path = ("experiments", name)
            if isinstance(one, TableExperiment):
                tables += self.table(name, one, base, path)
            else:
                own = [*common, ((*path, "set"), one.set)]
                where = ("scene",) if one.scene is None else (*path, "scene")
                study = self.scene(one.scene or file.scene, where, own)
                records += self.record(name, one, study, path)
        if base is None or self.faults:
            return None
        if choice is not None:
            free = _inherited(file, choice, base, (r.study for r in records)) | dict(free)
        users = [User(t.name, t.study, t.material, t.series.time is not None) for t in tables]
        users += [User(r.name, r.study) for r in records]
        parameters, wrong = read_parameters(free, users, at)
        self.tell(wrong)
        smooth, wrong = smooth_tables(free, parameters, at)
        self.tell(wrong)
        problem = FitProblem(
            file.title or self.path.stem, base, tuple(parameters), tuple(tables), tuple(records),
            tuple(smooth), file.method, str(self.path),
        )  # fmt: skip
        self.tell(whole_problems(problem, file, at))
        return problem

    def table(self, name: str, one: TableExperiment, study: Study | None, path: Path):
        """The table of an experiment, as a list of one or none."""
        wanted = [((*path, "strain"), one.strain, ""), ((*path, "tension"), one.tension, "N")]
        wanted += [] if one.time is None else [((*path, "time"), one.time, "s")]
        columns, wrong = read_data(self.folder / one.file, path, wanted)
        self.tell(wrong)
        if study is None:
            return []
        wrong = bench_problems(one, study, columns, path)
        if columns is not None and one.time is not None:
            wrong += check_history(columns, path)
        self.tell(wrong)
        if columns is None or wrong:
            return []
        strain, tension, *times = columns.values
        noise, problem = noise_of(one.noise, tension, "N", (*path, "noise"), one.tension)
        if problem is None and np.any(strain) and not np.any(tension):
            message = f"expected tensions, found nothing but 0 in column {one.tension.column}"
            problem = Problem((*path, "tension"), f"{message} of {columns.name}")
        self.tell([problem] if problem else [])
        time = times[0] if times else None
        series = Series(name, f"{name}: tension", "N", strain, "", tension, noise, time)
        return [Table(name, study, one.material, series)]

    def record(self, name: str, one: RecordExperiment, study: Study | None, path: Path):
        """The record of an experiment, as a list of one or none."""
        wanted: list[tuple[Path, Column, str]] = [((*path, "time"), one.time, "s")]
        for k, seen in enumerate(one.observe):
            wanted.append(((*path, "observe", k), seen, UNITS[seen.quantity]))
        columns, wrong = read_data(self.folder / one.file, path, wanted)
        self.tell(wrong)
        if columns is not None:
            self.tell(check_times(columns, path))
        if study is None:
            return []
        if columns is not None:
            long = length_problems(study, columns, one, path)
            self.tell(long or uncovered_problems(study, float(columns.values[0][-1]), path))
        if len(study.runs) > 1:
            keys = " and ".join(axis.key for axis in study.axes)
            message = f"expected one run, found a sweep of {len(study.runs)}: set {keys}"
            self.tell([Problem(path, message)])
            return []
        if (wrong := unknown_start(study.runs[0])) is not None:
            self.tell([Problem(path, wrong)])
        places, distances, series = [], [], []
        try:
            layout = make_layout(study.runs[0])
        except ValueError as error:
            self.tell([Problem(path, str(error))])
            return []
        for k, seen in enumerate(one.observe):
            spot: Path = (*path, "observe", k)
            try:
                what, distance = watched(
                    study.runs[0], layout, seen.quantity, seen.at, seen.component
                )
            except ValueError as error:
                self.tell([Problem((*spot, "at"), str(error))])
                continue
            places.append(what)
            distances.append(distance)
            if columns is not None:
                series.append(self.series(name, seen, columns, k, spot))
        if self.faults:
            return []
        return [Record(name, study, tuple(places), tuple(distances), tuple(series))]

    def series(self, name: str, seen, columns, k: int, path: Path) -> Series:
        """One observed column."""
        unit, values = UNITS[seen.quantity], columns.values[k + 1]
        noise, problem = noise_of(seen.noise, values, unit, (*path, "noise"), seen)
        self.tell([problem] if problem else [])
        sized = seen.component is None and seen.quantity in ("displacement", "velocity")
        if sized and values.size and np.min(values) < -SIGNED * np.max(np.abs(values)):
            message = (
                f'expected "x", "y" or "z" for data of a {seen.quantity} that are negative, down to '
                f"{format_quantity(float(np.min(values)), unit)}; without it its size is meant, found "
                "nothing"
            )
            self.tell([Problem((*path, "component"), message)])
        part = "" if seen.component is None else f" {seen.component}"
        label = f"{name}: {seen.quantity}{part} at {seen.at}"
        return Series(name, label, unit, columns.values[0], "s", values, noise)
