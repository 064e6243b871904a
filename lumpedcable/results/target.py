"""Files that appear whole, and replace a file of their own kind and nothing else that lies there."""

from __future__ import annotations

import csv
import os
import re
import secrets
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

from lumpedcable.results.disk import reported
from lumpedcable.results.errors import OutputError

__all__ = ["check_folder", "drafted", "followed", "is_draft", "keep_others", "whole"]

_HDF5 = b"\x89HDF\r\n\x1a\n"
_SIGNS = {
    "glTF": (0, b"glTF"),
    "MoorDyn": (0, b"Time\t"),
    ".gif": (0, b"GIF8"),
    ".mp4": (4, b"ftyp"),
}
"""By kind: what stands in every such file, and where."""
_LONGEST = 2**20  # bytes of a heading
_LEFT = 24 * 3600.0  # s after which nobody writes to a draft any more
_PAGE = b'<meta name="sources"'


def followed(target: Path) -> Path:
    """Where a symbolic link leads, so that it goes on leading there; any other path as it is."""
    return Path(os.path.realpath(target)) if os.path.islink(target) else target


@contextmanager
def whole(target: Path) -> Iterator[Path]:
    """A name beside the target to write to; the file gets its own name only when it is complete.

    The name is this writer's alone: of several that write one file at once, each puts its own there,
    and the last one's stays. It ends as the target's does, since some writers take the format from it.
    Of a target that is a symbolic link it lies beside the file that the link leads to, which is the one
    that is written.
    """
    target = followed(target)
    _clear_drafts(target)
    with drafted(target) as partial:
        yield partial


@contextmanager
def drafted(target: Path) -> Iterator[Path]:
    """The same beside a target that is no link, without a look at what others have left there."""
    # processes on other machines have numbers of their own
    own = f"{os.getpid()}-{secrets.token_hex(4)}"
    partial = target.with_name(f".{target.stem}.{own}.partial{target.suffix}")
    try:
        yield partial
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)


def is_draft(name: str, of: str) -> bool:
    """Whether a name is one to which `whole` writes a file that is to be called otherwise."""
    stem, suffix = Path(of).stem, Path(of).suffix
    own = rf"\.{re.escape(stem)}\.\d+-[0-9a-f]{{8}}\.partial{re.escape(suffix)}"
    return re.fullmatch(own, name) is not None


def _clear_drafts(target: Path) -> None:
    """Delete what processes that were killed have left of a target."""
    with suppress(OSError):  # what is wrong with the folder is told by whoever writes into it
        for name in os.listdir(target.parent):
            draft = target.with_name(name)
            if is_draft(name, target.name) and time.time() - draft.stat().st_mtime > _LEFT:
                draft.unlink()


def check_folder(folder: Path, file: Path | None = None) -> None:
    """Refuse a folder where nothing can be written, before somebody computes what would go there.

    It is not made: where it is missing, the nearest one that is there must take a new file.

    Args:
        folder: where files are to be written.
        file: the one that is, to be named; None of several.

    Raises:
        OutputError: a file is in its way, or the system refuses it.
    """
    what = f"cannot make the folder {folder}" if file is None else f"cannot write {file}"
    place = folder
    with reported(file or folder):
        while True:
            try:
                kind = os.stat(place).st_mode
                break
            except (FileNotFoundError, NotADirectoryError):
                if place == place.parent:
                    raise
                place = place.parent
        if not stat.S_ISDIR(kind):
            raise OutputError(f"{what}: expected a folder, found the file {place}")
        with tempfile.TemporaryFile(dir=place):
            pass


def keep_others(target: Path, kind: str) -> None:
    """Refuse to replace a file of another kind, which somebody may miss.

    Args:
        target: where a file is to be written; an empty one, or none, is no obstacle.
        kind: "results", "VTKHDF", "page", "CSV", or one of `_SIGNS`.

    Raises:
        OutputError: there is another file, and which is expected.
    """
    try:
        if not target.exists():
            return
        if not target.is_file():
            raise OutputError(f"cannot write {target}: expected a file name, found no plain file")
        if target.stat().st_size == 0 or _is(target, kind):
            return
    except OSError as error:
        raise OutputError(f"cannot write {target}: {error.strerror or error}") from error
    words = {"results": "a results file", "page": "a page of lumpedcable view"}
    expected = words.get(kind, f"a {kind.removeprefix('.')} file")
    raise OutputError(
        f"cannot write {target}: expected {expected} to replace or no file, found another one, "
        "which is kept: give another name, or delete it"
    )


def _is_heading(text: bytes) -> bool:
    """Whether a table of CSV begins as exports do: run, its case if it has one, what is swept, then time
    or status, then what is told of them; all but run, case and status have their unit in brackets."""
    line = text.split(b"\n")[0].decode("utf-8", "replace").rstrip()
    try:
        first, *others = next(csv.reader([line]), [""])
    except csv.Error:
        return False
    others = others[1:] if others[:1] == ["case"] else others
    bare = [name for name in others if not re.search(r" \[[^\[\]]+\]$", name)]
    return first == "run" and (bare == ["status"] or (not bare and "time [s]" in others))


def _is(path: Path, kind: str) -> bool:
    """Whether a file is of a kind, by what stands in it."""
    with path.open("rb") as file:
        head = file.read(16)
        if kind == "page":
            return _PAGE in head + file.read()
        if kind == "CSV":
            return _is_heading(head + file.readline(_LONGEST))
    if kind in _SIGNS:
        first, sign = _SIGNS[kind]
        return head[first : first + len(sign)] == sign
    if not head.startswith(_HDF5):
        return False
    try:
        with h5py.File(path, "r") as file:
            return "VTKHDF" in file if kind == "VTKHDF" else "schema_version" in file.attrs
    except BlockingIOError:
        return True  # somebody writes it, which the writer tells
    except OSError:
        return False  # cut off or damaged: nobody can say what it was
