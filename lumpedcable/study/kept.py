"""What programs do, kept for the next process.

Before a program can be compiled, or found compiled, its operations have to be followed through all of
the package: seconds, for a scene of several lines and bodies. What was followed is therefore kept beside
what was compiled. It is found again by all that it depends on: the package as it is, what it was given
but for the numbers, and the libraries that it was followed with.
"""

from __future__ import annotations

import dataclasses
import inspect
import io
import pickle
import zlib
from collections.abc import Callable
from functools import cache, wraps
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import jax
from jax import export

from lumpedcable.sources import SOURCES, code_of
from lumpedcable.study.devices import platform
from lumpedcable.study.fingerprint import HOLE, TREE, UntoldError, fingerprint
from lumpedcable.study.whole import write_whole

__all__ = ["kept", "program"]

ENDING = ".followed"
FOLLOWED_WITH = ("jax", "jaxlib", "equinox", "diffrax", "optimistix", "lineax", "numpy")
SETTINGS = (
    "jax_enable_x64", "jax_default_matmul_precision", "jax_numpy_dtype_promotion",
    "jax_numpy_rank_promotion", "jax_default_prng_impl",
)  # fmt: skip
QUICK = 1  # level of compression; more takes longer than it saves
KEEPS = True  # not where functions are replaced: a file would keep others than the package's


class Followed(NamedTuple):
    """The operations of a function of a flat list of arrays, and the tree of what comes out of it.

    Without a program they cannot be kept, which others need not try again.
    """

    program: export.Exported | None
    form: Any


def program(
    function: Callable[..., Any],
    static: tuple[str, ...] = (),
    options: dict[str, Any] | None = None,
) -> Any:
    """A function compiled once for all calls alike, and followed once for all processes: see `kept`.

    Args:
        function: of trees of arrays, to a tree of arrays.
        static: the names of its arguments that are structure.
        options: those of the compiler.
    """
    signature, name = inspect.signature(function), f"{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def follow(*arguments, **named):
        given = signature.bind(*arguments, **named).arguments
        fixed = {key: given[key] for key in given if key in static}
        free = {key: value for key, value in given.items() if key not in static}
        return kept(lambda free: function(**fixed, **free), (name, fixed), free)

    return jax.jit(follow, static_argnames=static, compiler_options=options)


def kept(function: Callable[..., Any], told: Any, *arguments: Any) -> Any:
    """`function(*arguments)`, to be traced, with its operations from the cache if they are there.

    What comes out is not to be differentiated or mapped. Where something is told or given that could be
    mistaken for something else, or there is no cache, the function is followed as if it were called.

    Args:
        function: of trees of arrays, to a tree of arrays.
        told: what the function depends on beside its arguments: its name, and all that it encloses.
        arguments: what it is given; their numbers are free, all else of them counts.
    """
    place = _place(told, arguments)
    if place is None:
        return function(*arguments)
    known = _read(place)
    found = _followed(function, arguments) if known is None else known
    if found.program is None:
        result = function(*arguments)  # tells what is wrong, if it is the function
    else:
        leaves = found.program.call(*jax.tree.leaves(arguments))
        result = jax.tree.unflatten(found.form, leaves)
    if known is None:
        _write(place, found)
    return result


def _place(told: Any, arguments: Any) -> Path | None:
    """The file of a program, None where it is not to be kept."""
    config: Any = jax.config
    folder = config.jax_compilation_cache_dir
    if not KEEPS or not SOURCES or not folder or "://" in folder or config.jax_disable_jit:
        return None
    leaves, tree = jax.tree.flatten(arguments)
    arrays = [(x.shape, str(x.dtype), x.weak_type) for x in leaves]
    try:
        return Path(folder) / (fingerprint(_surroundings(), told, tree, arrays) + ENDING)
    except UntoldError:
        return None


def _surroundings() -> Any:
    """What a program depends on beside what is told of it."""
    settings = [getattr(jax.config, name, None) for name in SETTINGS]
    return SOURCES, _versions(), platform(), settings


@cache
def _versions() -> list[str]:
    """Those of what is imported, which need not be what is installed by now."""
    return [import_module(name).__version__ for name in FOLLOWED_WITH]


def _followed(function: Callable[..., Any], arguments: Any) -> Followed:
    """The operations of a function, if they can be kept and nothing is wrong with it."""
    leaves, tree = jax.tree.flatten(arguments)
    form = None

    def flat(*values):
        nonlocal form
        found, form = jax.tree.flatten(function(*jax.tree.unflatten(tree, values)))
        return found

    given = [jax.ShapeDtypeStruct(x.shape, x.dtype, weak_type=x.weak_type) for x in leaves]
    try:
        return Followed(export.export(jax.jit(flat))(*given), form)
    except Exception:
        return Followed(None, None)


def _read(place: Path) -> Followed | None:
    """What a file tells, None if there is none, or one that is not understood."""
    try:
        found = Followed(*pickle.loads(zlib.decompress(place.read_bytes())))
    except Exception:
        return None
    return found if isinstance(found.program, export.Exported | None) else None


def _write(place: Path, found: Followed) -> None:
    """Keep it if that can be done; without it everything works, only slower."""
    if code_of() != SOURCES:
        return
    whole, plain = io.BytesIO(), found.program
    try:
        if plain is not None:
            plain = dataclasses.replace(plain, _get_vjp=None)
        _Pickler(whole).dump((plain, found.form))
        write_whole(place, zlib.compress(whole.getvalue(), QUICK))
    except Exception:
        return


class _Pickler(pickle.Pickler):
    def reducer_override(self, obj: Any) -> Any:
        """A tree's structure as a tree without arrays, since jax keeps only those of plain trees."""
        if isinstance(obj, TREE):
            return jax.tree.structure, (jax.tree.unflatten(obj, [HOLE] * obj.num_leaves),)
        return NotImplemented
