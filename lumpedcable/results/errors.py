"""Errors of the results file, each with a one-line message meant for the user."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path


class OutputError(Exception):
    """The results cannot be written where they were asked for; the message says where and why."""


class DiskError(OutputError):
    """The disk is full or gone: nothing else can be written there either."""


class BusyError(OutputError):
    """Another process writes it now."""


class ResultError(Exception):
    """A file cannot be read as a result, or lacks what was asked of it; the message says why."""


def first_line(said: object, otherwise: str = "") -> str:
    """The first line that is not empty of what an error or a note says.

    Where it says nothing: `otherwise`, or the kind of the error.
    """
    lines = (line.strip() for line in str(said).splitlines())
    return next(filter(None, lines), otherwise or type(said).__name__)


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The name nearest to one that is not there, None where none is near."""
    return next(iter(difflib.get_close_matches(name, list(known), 1)), None)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """'; did you mean "..."?' with the nearest name, "" where none is near."""
    close = nearest(name, known)
    return f'; did you mean "{close}"?' if close else ""


def check_known(path: Path, what: str, name: str, known: Iterable[str]) -> None:
    """Raise ResultError, with the nearest name, where a file has no such `what`."""
    known = list(known)
    if name not in known:
        close = nearest(name, known)
        hint = f"nearest: {close}" if close else f"there is {', '.join(known) or 'none'}"
        raise ResultError(f"{path}: no {what} {name!r}; {hint}")
