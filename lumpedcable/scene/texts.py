"""Text files that a person names: read, or why they cannot be."""

from __future__ import annotations

import os
from pathlib import Path as FilePath

from lumpedcable.scene.part import did_you_mean

__all__ = ["FileError", "named_file", "read_text"]

HDF5 = b"\x89HDF\r\n\x1a\n"  # how such a file begins


class FileError(Exception):
    """A file that cannot be used; the message follows "expected ... found"."""


def named_file(folder: FilePath, name: str) -> FilePath:
    """Return the path of a file that is named relative to a folder, or from "~", the user's home, on.

    Raises:
        FileError: the name is empty, and would mean the folder itself.
    """
    if not name.strip():
        raise FileError(f'expected the name of a file, found "{name}"')
    return folder / os.path.expanduser(name)


def read_text(path: FilePath) -> str:
    """Return the text of a UTF-8 file.

    Raises:
        FileError: there is no such file, it is a directory, or it is not UTF-8 text.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = did_you_mean(path.name, [name for name in siblings if name.endswith(path.suffix)])
        raise FileError(f'expected a file, found none at "{path}"{hint}') from None
    except IsADirectoryError:
        raise FileError("expected a file, found a directory") from None
    except UnicodeDecodeError as error:
        if error.object.startswith(HDF5):
            raise FileError(
                "expected text, found a results file (HDF5): lumpedcable info, plot and view take it"
            ) from None
        line = error.object.count(b"\n", 0, error.start) + 1
        byte = error.object[error.start]
        raise FileError(
            f"expected UTF-8 text, found byte 0x{byte:02x} in line {line}; save it as UTF-8"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"expected a file that can be read, found: {reason}") from None
