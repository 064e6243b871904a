"""A study on the disk: a folder of results files, each of some of its runs, finished or absent.

::

    study.toml                  the whole scene and sweep, in SI numbers
    study.json                  number of runs, runs in each shard, digest of study.toml, version,
                                what the names of the shards begin with, the program
    study.h5                    all shards as one results file, by reference
    shards/1b2c3d4e-000000.h5   runs 0 to shard - 1, and so on; a results file like any other
    shards/1b2c3d4e-000000.txt  why a shard could not be computed, until it is

HDF5 looks for the file of a reference beside the one that refers to it and then in the folder that
the process is in, so two studies must not have shards of one name. A shard is written under another
name and renamed when it is complete, so that whoever finds one finds all of it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import Any

from lumpedcable.results.disk import reported
from lumpedcable.results.errors import DiskError, OutputError, ResultError
from lumpedcable.results.opening import read_only
from lumpedcable.results.schema import PARTIAL_SUFFIX
from lumpedcable.results.target import followed, is_draft, whole

__all__ = ["Manifest", "StudyFolder", "is_study_folder"]

MANIFEST, SCENE, VIEW, SHARDS = "study.json", "study.toml", "study.h5", "shards"


@dataclass(frozen=True)
class Manifest:
    """What a study folder says of itself."""

    runs: int
    """Number of runs of the study."""
    shard: int
    """Runs in each shard but the last."""
    digest: str
    """SHA-256 of study.toml."""
    version: str
    """Version of lumpedcable that computes it; parts of two are not mixed."""
    names: str = ""
    """What the names of the shards begin with, of no other study; "" where a study says nothing."""
    program: Mapping[str, str] = field(default_factory=dict, hash=False)
    """What else computes it by name, sources and libraries; {} where a study says nothing."""

    @classmethod
    def new(
        cls, runs: int, shard: int, digest: str, version: str, program: Mapping[str, str]
    ) -> Manifest:
        """Of a study that begins: the same wherever the same study begins."""
        told = json.dumps([runs, shard, digest, version, *sorted(program.items())])
        names = hashlib.sha256(told.encode()).hexdigest()[:8] + "-"
        return cls(runs, shard, digest, version, names, dict(program))

    @classmethod
    def read(cls, path: Path) -> Manifest:
        """Of a study that is there; what only a later version says of it is left out.

        Raises:
            FileNotFoundError: there is none.
            ResultError: it is damaged.
        """
        try:
            told = json.loads(path.read_text(encoding="utf-8"))
            own = {one.name for one in fields(cls)}
            manifest = cls(**{name: value for name, value in told.items() if name in own})
        except FileNotFoundError:
            raise
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise ResultError(f"{path} is damaged: {error}") from error
        for name in ("runs", "shard"):
            found = told[name]
            if type(found) is not int or found < 1:
                raise ResultError(
                    f"{path} is damaged: {name}: expected a whole number from 1 on, "
                    f"found {json.dumps(found)}"
                )
        if not isinstance(manifest.program, dict):
            raise ResultError(
                f"{path} is damaged: program: expected a table, found "
                f"{json.dumps(manifest.program)}"
            )
        return manifest


@dataclass(frozen=True)
class StudyFolder:
    """A study folder that exists."""

    path: Path
    manifest: Manifest

    @property
    def scene(self) -> Path:
        """The study's own scene file."""
        return self.path / SCENE

    @property
    def view(self) -> Path:
        """The results file that shows all shards."""
        return self.path / VIEW

    @property
    def shards(self) -> int:
        """Number of shards of the whole study."""
        return -(-self.manifest.runs // self.manifest.shard)

    def runs(self, shard: int) -> range:
        """The runs of a shard."""
        first = shard * self.manifest.shard
        return range(first, min(first + self.manifest.shard, self.manifest.runs))

    def file(self, shard: int) -> Path:
        """Where a shard stands once it is finished."""
        return self.path / self.name(shard)

    def name(self, shard: int) -> str:
        """Name of a shard's file from the folder."""
        return f"{SHARDS}/{self.manifest.names}{shard:06d}.h5"

    def parts(self) -> list[tuple[str, int]]:
        """Every shard's file from the folder, there or not, and its number of runs."""
        return [(self.name(shard), len(self.runs(shard))) for shard in range(self.shards)]

    def missing(self) -> list[int]:
        """Shards that are not finished."""
        there = self._there(".h5")
        return [shard for shard in range(self.shards) if shard not in there]

    def begun(self) -> list[int]:
        """Shards that somebody writes, or has left unfinished."""
        return sorted(self._there(f".h5{PARTIAL_SUFFIX}"))

    def refuse_misnamed(self) -> None:
        """Refuse a shard under the name of another, as somebody may have copied it.

        One that cannot be read is told by whoever reads what it holds.

        Raises:
            ResultError: it holds other runs than those of its name.
        """
        missing = set(self.missing())
        for shard in range(self.shards):
            file, runs = self.file(shard), self.runs(shard)
            if shard in missing:
                continue
            with suppress(OSError, KeyError):
                seen = file.stat()
                first, last = _runs_in(file, (seen.st_ino, seen.st_mtime_ns, seen.st_size))
                if (first, last) != (runs[0], runs[-1]):
                    raise ResultError(
                        f"{file} is damaged: expected runs {runs[0]} to {runs[-1]}, found {first} to "
                        f"{last}; once it is deleted, lumpedcable study computes it again"
                    )

    def note_failure(self, shard: int, reason: str) -> None:
        """Keep why a shard could not be computed, unless another process has computed it meanwhile.

        Raises:
            DiskError: the folder has gone.
            OutputError: it cannot be written.
        """
        if self.file(shard).exists():
            return
        self.refuse_gone()
        note = self._reason(shard)
        with reported(note):
            note.parent.mkdir(exist_ok=True)
            _place(note, reason + "\n")

    def forget_failure(self, shard: int) -> None:
        """A shard has been computed after all."""
        self._reason(shard).unlink(missing_ok=True)

    def failures(self) -> dict[int, str]:
        """Why shards that are not there could not be computed."""
        found = {}
        for shard in sorted(self._there(".txt") - self._there(".h5")):
            with suppress(FileNotFoundError):  # another process has computed it meanwhile
                found[shard] = self._reason(shard).read_text(encoding="utf-8").strip()
        return found

    def _there(self, ending: str) -> set[int]:
        """Shards of which there is a file whose name ends so."""
        found: list[str] = []
        with suppress(FileNotFoundError):  # whoever has deleted the folder has deleted them all
            found = os.listdir(self.path / SHARDS)
        numbers = (
            name.removeprefix(self.manifest.names).removesuffix(ending)
            for name in found
            if name.startswith(self.manifest.names) and name.endswith(ending)
        )
        return {int(number) for number in numbers if number.isdecimal()}

    def _reason(self, shard: int) -> Path:
        return self.file(shard).with_suffix(".txt")

    @classmethod
    def open(cls, path: Path) -> StudyFolder:
        """Open a study folder.

        Raises:
            ResultError: it is none, or it is damaged, or its scene is not that of its shards.
        """
        try:
            known = cls(path, Manifest.read(path / MANIFEST))
        except FileNotFoundError:
            raise ResultError(f"{path} is no study folder (it has no {MANIFEST})") from None
        known._refuse_changed()
        return known

    @classmethod
    def make(
        cls, path: Path, text: str, runs: int, shard: int | None, version: str,
        usual: int | None = None, program: Mapping[str, str] | None = None,
    ) -> StudyFolder:  # fmt: skip
        """Open the folder of a study, or make it.

        Args:
            path: the folder.
            text: the whole scene and sweep (study.toml).
            runs: number of runs.
            shard: runs in a shard; None for what the folder has, or what is usual.
            version: of lumpedcable.
            usual: runs in a shard of a folder that is new; None: all.
            program: what else computes it by name, sources and libraries.

        Raises:
            OutputError: it cannot be made, or it holds something else.
        """
        digest = hashlib.sha256(text.encode()).hexdigest()
        manifest = path / MANIFEST
        with reported(path):
            if not manifest.exists():
                found = _other(path, text)
                # what others have put there meanwhile comes after their manifest
                if found is not None and not manifest.exists():
                    raise OutputError(
                        f"cannot write {path}: expected a new or empty folder, found {found}"
                    )
                (followed(path) / SHARDS).mkdir(parents=True, exist_ok=True)
            if not manifest.exists():
                size = shard or usual or runs
                made = Manifest.new(runs, size, digest, version, program or {})
                _place(path / SCENE, text)
                # last, since it is what makes the folder a study
                _place(manifest, json.dumps(asdict(made), indent=2) + "\n")
        known = cls.open(path)
        known._refuse_other(digest, shard)
        known.refuse_program(version, program or {})
        with reported(path):
            (path / SHARDS).mkdir(exist_ok=True)
        return known

    def _refuse_changed(self) -> None:
        """Shards of two scenes would be taken for one study."""
        try:
            found = hashlib.sha256(self.scene.read_bytes()).hexdigest()
        except OSError as error:
            raise ResultError(f"{self.scene}: cannot be read: {error.strerror or error}") from error
        if found != self.manifest.digest:
            raise ResultError(
                f"{self.scene}: expected the scene that the study was begun with, found a changed "
                "one: put it back, or give another folder to a study of the new one"
            )

    def refuse_gone(self) -> None:
        """Whoever goes on in a folder that was moved or deleted would begin another one.

        Raises:
            DiskError: it is no longer where it was.
        """
        if not is_study_folder(self.path):
            raise DiskError(
                f"the study folder {self.path} has gone, moved or deleted meanwhile: once it is back "
                "there, the same command goes on with the shards that it holds"
            )

    def refuse_program(self, version: str, program: Mapping[str, str]) -> None:
        """Shards of two programs would be taken for those of one.

        A folder that says nothing of its program but the version takes all of that version.

        Raises:
            OutputError: they are another program's than this one.
        """
        theirs = {"lumpedcable": self.manifest.version, **self.manifest.program}
        ours = {"lumpedcable": version, **(program if self.manifest.program else {})}
        names = [name for name in {**theirs, **ours} if theirs.get(name) != ours.get(name)]
        if names:
            found, this = (
                ", ".join(f"{name} {one.get(name) or 'unknown'}" for name in names)
                for one in (theirs, ours)
            )
            raise OutputError(
                f"cannot go on in {self.path}: it was begun with {found}, this is {this}, whose "
                "shards are not mixed with those: give another folder, or go on with that program"
            )

    def _refuse_other(self, digest: str, shard: int | None) -> None:
        known = self.manifest
        if known.digest != digest:
            raise OutputError(
                f"cannot go on in {self.path}: it holds another study; see {self.scene}, or give "
                "another folder"
            )
        if shard not in (None, known.shard):
            raise OutputError(
                f"cannot go on in {self.path}: its shards have {known.shard} runs, found --shard "
                f"{shard}"
            )


HOW_TO_SHOW = "lumpedcable study makes it: run the command that the study was begun with"
"""What to do where there is no file that shows all shards."""


def is_study_folder(path: Path) -> bool:
    """Whether there is a study folder at a path."""
    return (path / MANIFEST).is_file()


@lru_cache(2**16)
def _runs_in(file: Path, seen: tuple[int, int, int]) -> tuple[int, int]:
    """The first and the last run of a shard; one that looks as it was `seen` before is not opened."""
    with read_only(file) as known:
        runs: Any = known["run"]
        return int(runs[0]), int(runs[-1])


def _other(path: Path, text: str) -> str | None:
    """What is at a path but a study that is being made, by another process or by one that was killed.

    Of such a one, with a scene of this text, there is a folder without shards, the scene and drafts.
    """
    try:
        # asked once: a folder that another process makes between two questions is no file
        names = os.listdir(path)
    except FileNotFoundError:
        return None
    except NotADirectoryError:
        return "a file"
    for name in sorted(names):
        one = path / name
        if name == SHARDS:
            own = one.is_dir() and not os.listdir(one)
        elif name == SCENE:
            own = one.is_file() and one.read_bytes() == text.encode()
        else:
            own = is_draft(name, SCENE) or is_draft(name, MANIFEST)
        if not own:
            return name
    return None


def _place(path: Path, text: str) -> None:
    """Write a text file that is there as a whole or not at all."""
    with whole(path) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")
