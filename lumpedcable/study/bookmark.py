"""How far a run has come, noted beside its results file, so that the same command goes on from there.

A note is whole or absent, and belongs to the temporary file that it was made with. It holds what a
process knows and the file does not: the state of the runs that are under way, what is kept of them for
their summaries, and the summaries of those that have ended. Starts are found again, as the first time.
"""

from __future__ import annotations

import hashlib
import json
import os
import time as clock
import zipfile
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from lumpedcable.results import open_result
from lumpedcable.results.errors import ResultError
from lumpedcable.results.schema import partial_of
from lumpedcable.results.target import followed, whole
from lumpedcable.sources import SOURCES
from lumpedcable.study.contents import versions
from lumpedcable.study.devices import platform
from lumpedcable.study.triggers import Triggers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.account import Account
    from lumpedcable.study.contents import Contents
    from lumpedcable.study.outcome import Table
    from lumpedcable.study.shrinking import Batch

__all__ = ["Bookmark", "bookmark_of"]

EVERY = 10.0  # s from a note to the next, at least
PRICE = 20  # and at least so many times what it takes to write one


def bookmark_of(target: Path) -> Path:
    """Where it is noted how far the runs of a results file have come."""
    target = followed(target)
    return target.with_name(target.name + ".bookmark")


class Bookmark:
    """Notes of how far the runs of a results file have come, and what an earlier process has noted.

    Args:
        contents: the file.
        target: its name.
        kept: whether notes are made; else none is looked for either.
    """

    def __init__(self, contents: Contents, target: Path, kept: bool):
        self.path = bookmark_of(target)
        self._kept, self._contents = kept, contents
        self._found = self._read(partial_of(followed(target))) if kept else {}
        self.goes_on: bool = bool(self._found)
        self._created = str(self._found.get("created", contents.created))
        self._tables: list[Table] = []
        self._parts = 0  # of the last table, those that have ended
        self._last, self._took = clock.monotonic(), 0.0

    def _read(self, partial: Path) -> dict[str, NDArray[Any]]:
        """The note of a process that was interrupted in the same work; {} where there is none."""
        try:
            with self.path.open("rb") as note, np.load(note, allow_pickle=False) as file:
                found = {name: file[name] for name in file.files}
            with open_result(partial) as file:
                made = str(file.attributes["created"])
        except (ResultError, OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):
            return {}
        told = (str(found.get("key", "")), str(found.get("created", "")))
        return found if told == (self._key, made) else {}

    @cached_property
    def _key(self) -> str:
        """What has to be the same for a run to go on as it began: all numbers of the scene, the runs,
        the program, and what computes."""
        contents = self._contents
        parts = [contents.study.effective_text, contents.runs.tolist(), versions(), SOURCES]
        parts += [platform(), jax.device_count(), os.cpu_count()]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()

    # --- going on ---------------------------------------------------------------------------

    def table(self, empty: Table) -> Table:
        """The next table of summaries, as far as it was filled."""
        number = len(self._tables)
        for path, values in empty.items():
            noted = self._found.get(f"table{number}/{path}")
            if noted is not None:
                values[...] = noted
        self._tables.append(empty)
        self._parts = 0
        return empty

    @property
    def passed(self) -> bool:
        """Whether the runs of the last table had all ended."""
        return len(self._tables) < int(self._found.get("tables", 0))

    def passes(self) -> bool:
        """Whether the next part of the last table's runs had ended; called once for each."""
        known = len(self._tables) == int(self._found.get("tables", 0))
        if known and self._parts < int(self._found["parts"]):
            self._parts += 1
            return True
        return False

    def resume(self, account: Account, batch: Batch, triggers: Triggers) -> int:
        """Put the part that begins where it was, if it was under way.

        Returns:
            How many of its outputs are there.
        """
        found, self._found = self._found, {}
        if "done" not in found:
            return 0
        for event, starts in triggers.starts.items():
            starts[...] = found[f"starts/{event}"]
        batch.resume({k[6:]: v for k, v in found.items() if k.startswith("batch/")})
        account.restore({k[8:]: v for k, v in found.items() if k.startswith("account/")})
        return int(found["done"])

    # --- noting -----------------------------------------------------------------------------

    def ended(self) -> None:
        """A part has ended."""
        self._parts += 1
        if self._due():
            self._write({})

    def note(self, done: int, account: Account, batch: Batch) -> None:
        """The first `done` outputs of a part are in the file, and summed up in the account."""
        if self._due():
            self._write(
                {"done": np.asarray(done)}
                | {f"batch/{name}": values for name, values in batch.noted().items()}
                | {f"account/{name}": values for name, values in account.noted().items()}
                | {f"starts/{event}": values for event, values in account.starts.items()}
            )

    def _due(self) -> bool:
        waited = clock.monotonic() - self._last
        return self._kept and waited >= max(EVERY, PRICE * self._took)

    def _write(self, state: dict[str, NDArray[Any]]) -> None:
        begun = clock.monotonic()
        found = state | {
            "key": np.asarray(self._key),
            "created": np.asarray(self._created),
            "tables": np.asarray(len(self._tables)),
            "parts": np.asarray(self._parts),
        }
        for number, table in enumerate(self._tables):
            for path, values in table.items():
                plain = values.astype(str) if values.dtype == object else values
                found[f"table{number}/{path}"] = plain
        # without a note no more is lost than the time that it would have saved
        with suppress(OSError), whole(self.path) as draft, draft.open("wb") as file:
            np.savez(file, **found)  # pyright: ignore[reportArgumentType]
            file.flush()
            os.fsync(file.fileno())
        self._last = clock.monotonic()
        self._took = self._last - begun

    def remove(self) -> None:
        """There is nothing to go on with."""
        if self._kept:
            with suppress(OSError):  # it fits no other file, so that it may stay
                self.path.unlink()
