"""The package from Python: run a scene, look at what came out.

    import lumpedcable as lc

    result = lc.run("configs/snapback.toml", pretension=[45e3, 90e3])
    result.line("rope").tension.isel(run=0, time=-1)
    result.view()

Everything that takes time to import is imported when it is used.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lumpedcable.results.disk import reported
from lumpedcable.results.errors import OutputError, ResultError, check_known
from lumpedcable.results.joined import copy_whole
from lumpedcable.results.opening import how_locked
from lumpedcable.results.reader import open_result
from lumpedcable.results.target import keep_others, whole
from lumpedcable.scene import SceneError, Study, load_study
from lumpedcable.shown import Drawn, Figures, Page

if TYPE_CHECKING:
    import xarray

__all__ = ["Figures", "OutputError", "Page", "Result", "ResultError", "SceneError", "open", "run"]


class _Temporary:
    """A folder that goes with the last of the results that share it."""

    def __init__(self, folder: str) -> None:
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)

    def __deepcopy__(self, memo: dict[int, Any]) -> _Temporary:
        return self

    def __reduce__(self) -> NoReturn:
        raise TypeError("a result in a temporary folder cannot be pickled: save() it first")


class Result(Drawn):
    """A results file.

    Attributes:
        path: where it lies, of a study's folder its study.h5; in a temporary folder, gone with this
            object and its copies, where none was asked for.
    """

    def __init__(self, path: str | Path, folder: str | None = None) -> None:
        """Look at a file; `folder` is a temporary one that goes with this object.

        Raises:
            ResultError: there is none, or it is not a results file.
        """
        self._folder = None if folder is None else _Temporary(folder)
        with open_result(path) as file:
            self.path: Path = file.path  # of a study's folder the file that shows all its runs
            self._lines, self._bodies, self._cables = file.lines, file.bodies, file.cables
            self._status, self._ends = file.status, file.ends
        self._labels: list[str] | None = None  # of very many runs they take long

    @property
    def lines(self) -> list[str]:
        """Names of the lines."""
        return list(self._lines)

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies whose motion was kept."""
        return list(self._bodies)

    @property
    def cables(self) -> list[str]:
        """Names of the cables at rest, of a scene without duration."""
        return list(self._cables)

    @property
    def labels(self) -> list[str]:
        """What sets each run apart, e.g. "pretension 45 kN"; "" without a sweep."""
        if self._labels is None:
            with open_result(self.path) as file:
                self._labels = [file.label(run) for run in range(file.runs)]
        return list(self._labels)

    @property
    def status(self) -> list[str]:
        """How each run ended: "ok", or a word for what went wrong."""
        return list(self._status)

    def line(self, name: str) -> xarray.Dataset:
        """The fields of a line with names, units and coordinates, read from the file when used.

        Raises:
            ResultError: there is no such line, or xarray is not installed.
        """
        with open_result(self.path) as file:
            file.line(name)  # tells of a wrong name
        return self._opened(f"lines/{name}")

    def body(self, name: str) -> xarray.Dataset:
        """Place (m), attitude (rad) and their rates of a body, (run, time, 3).

        Raises:
            ResultError: there is no such body, or xarray is not installed.
        """
        return self._opened(f"bodies/{self._known('body', name, self._bodies)}")

    def rest(self, cable: str) -> xarray.Dataset:
        """Length, sag and tensions of a cable at rest, (run,), with the exact ones where there are.

        Raises:
            ResultError: there is no such cable, or xarray is not installed.
        """
        return self._opened(f"rest/{self._known('cable', cable, self._cables)}")

    @property
    def measures(self) -> xarray.Dataset:
        """The histories (run, time) of the numbers that the scene asks for; NaN while none counts.

        Raises:
            ResultError: the scene asks for none, or keeps none, or xarray is not installed.
        """
        with open_result(self.path) as file:
            if not file.measures():
                none = "the scene asks for no measures, see [measures.NAME]"
                if file.scene.get("measures"):
                    none = "has no histories of its measures, see output.keep"
                raise ResultError(f"{self.path}: {none}")
        return self._opened("measures")

    @property
    def dataset(self) -> xarray.Dataset:
        """What belongs to the runs as a whole: swept numbers, status."""
        return self._opened(None)

    @property
    def energy(self) -> xarray.Dataset:
        """The energies in J, (run, time).

        Raises:
            ResultError: none are kept, or xarray is not installed.
        """
        with open_result(self.path) as file:
            if not file.energy_terms:
                raise ResultError(
                    f"{self.path}: has no energies, see output.quantities and output.keep"
                )
        return self._opened("energy")

    def summary(self, end: str | None = None) -> xarray.Dataset:
        """The numbers of the runs: those of the whole run, or of a recoiling end such as "rope.end"."""
        if end is not None:
            self._known("recoiling end", end, self._ends)
        return self._opened("summary" if end is None else f"summary/{end}")

    def figures(self) -> Figures:
        """The figures that `lumpedcable plot` draws, by name.

        Raises:
            ResultError: there is nothing to draw.
        """
        from lumpedcable.view import figures_of

        return Figures(figures_of(self.path))

    def _drawn(self, folder: Path, formats: Sequence[str]) -> list[Path]:
        from lumpedcable.view import plot_result

        return plot_result(self.path, folder, formats)

    def view(self, run: int | None = None) -> Page:
        """The moving scene as a page: a notebook shows it, `.save("page.html")` writes it.

        Args:
            run: the one that it opens with; the first if None.

        Raises:
            ResultError: the file holds no positions, or no such run.
        """
        from lumpedcable.page.document import document
        from lumpedcable.page.recorded import recorded

        payload = recorded(self.path, run)
        return Page(document(payload, payload.pack.text()))

    def animate(self, path: str | Path, run: int = 0, seconds: float = 8.0) -> Path:
        """Write a run as a GIF or MP4, see `lumpedcable.view.animate_result`."""
        from lumpedcable.page.filmed import beside_lines
        from lumpedcable.view import animate_result

        return animate_result(self.path, path, run, seconds, beside=beside_lines)

    def export(self, kind: str, path: str | Path, run: int | None = None) -> list[Path]:
        """Write it for another program, see `lumpedcable.export.export_result`."""
        from lumpedcable.export import export_result

        return export_result(self.path, kind, path, run)

    def save(self, path: str | Path) -> Path:
        """Copy the results file, and go on with the copy; that of a study has all its runs in it.

        Raises:
            OutputError: it cannot be written there.
        """
        target = Path(path)
        keep_others(target, "results")
        with reported(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.exists() and target.samefile(self.path):
                raise OutputError(f"cannot write {target}: expected another file than the results")
            with whole(target) as partial:
                copy_whole(self.path, partial)
        self.path, self._folder = target, None
        return target

    def __repr__(self) -> str:
        good = self._status.count("ok")
        return (
            f"Result({str(self.path)!r}: {len(self._status)} runs, {good} ok; lines {self._lines})"
        )

    def _known(self, what: str, name: str, known: Sequence[str]) -> str:
        check_known(self.path, what, name, known)
        return name

    def _opened(self, group: str | None) -> xarray.Dataset:
        try:
            import xarray
        except ImportError:
            raise ResultError(
                'labelled arrays need the extra "xarray": pip install "lumpedcable[xarray]"'
            ) from None
        try:
            locking = {"locking": how_locked(self.path)}
            how: dict[str, Any] = {"engine": "h5netcdf", "driver_kwds": locking}
            found = xarray.open_dataset(self.path, group=group, **how)
        except (OSError, KeyError, ValueError) as error:
            raise ResultError(
                f"{self.path}: {group or 'the file'} cannot be opened: {error}"
            ) from error
        if group is None:
            return found
        # times, axes and swept numbers stand at the root of the file
        root = xarray.open_dataset(self.path, **how)
        shared = {name: root[name] for name in root.variables if set(root[name].dims) <= {"run"}
                  and "key" in root[name].attrs}  # fmt: skip
        shared |= {name: root[name] for name in root.variables
                   if name in found.dims and root[name].dims == (name,)}  # fmt: skip
        return found.assign_coords({k: x for k, x in shared.items() if k not in found.data_vars})


def open(path: str | Path) -> Result:
    """Look at a results file, or at the folder of a study.

    Raises:
        ResultError: there is none, or it is not a results file.
    """
    return Result(path)


def run(
    scene: str | Path,
    changes: Mapping[str, Any] | None = None,
    *,
    output: str | Path | None = None,
    **more: Any,
) -> Result:
    """Run a scene, with its sweep as one batch.

    Args:
        scene: scene file (TOML).
        changes: other values by key, a dotted path or its unmistakable end:
            {"break.time": "5 ms", "segments": 100}. A list makes the key an axis of the sweep.
        output: results file to keep; None for a temporary one that goes with the result.
        more: changes whose key is one word, e.g. pretension=[45e3, 90e3].

    Returns:
        The result. A run that failed is no error; `status` tells of it.

    Raises:
        SceneError: the scene or a change is wrong; the message lists every fault.
        OutputError: the file cannot be written.
    """
    study = changed_study(scene, changes, more)
    folder = None
    if output is None:
        folder = tempfile.mkdtemp(prefix="lumpedcable-")
        output = Path(folder) / f"{Path(scene).stem}.h5"
    keep_others(Path(output), "results")
    from lumpedcable.study.run import run_study

    try:
        run_study(study, Path(output))
        return Result(output, folder)
    except BaseException:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def changed_study(
    scene: str | Path, changes: Mapping[str, Any] | None, more: Mapping[str, Any]
) -> Study:
    """A scene with other values by key, as `run` takes them.

    Raises:
        SceneError: the scene or a change is wrong; the message lists every fault.
    """
    if changes is not None and not isinstance(changes, Mapping):
        raise TypeError(f"changes: expected values by key, found {type(changes).__name__}")
    if both := sorted((changes or {}).keys() & more.keys()):
        raise TypeError(f"{both[0]}: expected it once, found it among the changes and as a word")
    texts = [f"{key}={_text(value)}" for key, value in {**(changes or {}), **more}.items()]
    return load_study(scene, texts)


def study_with_run(
    scene: str | Path, changes: Mapping[str, Any] | None, more: Mapping[str, Any], run: int
) -> Study:
    """The same, which has a run of this number.

    Raises:
        SceneError: the scene or a change is wrong.
        ValueError: it has no such run.
    """
    study = changed_study(scene, changes, more)
    if not (isinstance(run, int | np.integer) and 0 <= run < len(study.runs)):
        raise ValueError(f"run: expected one from 0 to {len(study.runs) - 1}, found {run!r}")
    return study


def _text(value: Any) -> str:
    """A value as `--set` takes it."""
    if isinstance(value, str):
        return value if value.strip() else _toml(value)  # after `=` a blank is no value
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    return _toml(value)


def _toml(value: Any) -> str:
    # of NumPy, jax or whoever makes arrays, and numbers of types of their own; what a mask hides is
    # no value, and TOML has no gaps
    if hasattr(value, "__array__") and not isinstance(value, np.ma.MaskedArray):
        value = np.asarray(value).tolist()
    if isinstance(value, bool | str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return _text(value)
    if isinstance(value, int):
        return repr(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray | memoryview):
        return f"[{', '.join(_toml(item) for item in value)}]"
    raise TypeError(f"expected a number, a text, a list or a table, found {type(value).__name__}")
