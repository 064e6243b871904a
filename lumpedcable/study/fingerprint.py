"""What structure is, in words that are the same in every process."""

import dataclasses
import enum
import types
from typing import Any

import jax
import numpy as np

from lumpedcable.sources import digest

__all__ = ["HOLE", "TREE", "UntoldError", "fingerprint"]

TREE = type(jax.tree.structure(0))
HOLE = "*"  # stands for an array where a tree is told by its structure
KNOWN = {__name__.partition(".")[0], "builtins", "diffrax", "equinox", "jax", "numpy"}


class UntoldError(Exception):
    """Something whose words could be the same as those of something else."""


def fingerprint(*things: Any) -> str:
    """32 hexadecimal digits that are the same where things are equal, whichever process asks.

    Modules, named tuples and other data classes are told by their class and all that is in them, tree
    structures by what they are the structure of, classes and functions by where they are defined.

    Raises:
        UntoldError: there is something else among them, such as an array, a function that was made by
            another, or a class of somebody else.
    """
    return digest(repr(_told(things)).encode())


def _told(x: Any) -> Any:
    if isinstance(x, TREE):
        return "tree", _told(jax.tree.unflatten(x, [HOLE] * x.num_leaves))
    if isinstance(x, type | types.FunctionType | types.BuiltinFunctionType):
        return "named", _named(x)
    return _named(type(x)), _words(x)


def _words(x: Any) -> Any:
    if isinstance(x, enum.Enum):
        return x.name
    if x is None or isinstance(x, bool | int | float | complex | str | bytes | np.dtype):
        return repr(x)
    if isinstance(x, dict | types.MappingProxyType):
        return [(_told(key), _told(value)) for key, value in x.items()]
    if isinstance(x, set | frozenset):
        return sorted(repr(_told(value)) for value in x)
    if dataclasses.is_dataclass(x):
        fields = (field.name for field in dataclasses.fields(x) if field.compare)
        return [(name, _told(getattr(x, name))) for name in fields if hasattr(x, name)]
    if isinstance(x, list | tuple):
        return [_told(value) for value in x]
    raise UntoldError(_named(type(x)))


def _named(x: Any) -> str:
    """Where a class or function is defined; there is one of that name."""
    module, name = x.__module__ or "", x.__qualname__
    if module.partition(".")[0] not in KNOWN or "<" in name:
        raise UntoldError(f"{module}.{name}")
    return f"{module}.{name}"
