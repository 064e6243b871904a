"""Fits and sensitivities from Python: what the commands `fit` and `sensitivity` find, as objects.

    import lumpedcable as lc

    found = lc.fit("configs/fit/nylon-bench.toml")
    found["materials.nylon.p2"].value
    found.plot("pictures")

Everything that takes time to import is imported when it is used.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lumpedcable.api import study_with_run
from lumpedcable.shown import Drawn, Figures

if TYPE_CHECKING:
    from lumpedcable.fitting.response import Response
    from lumpedcable.fitting.run import Fitted
    from lumpedcable.fitting.sensitivity import Sensitivity as Slopes
    from lumpedcable.scene import Study
    from lumpedcable.view.fit import FitPictures

__all__ = [
    "Dependence",
    "Fit",
    "FoundNumber",
    "Sensitivity",
    "fit",
    "fit_ropes",
    "response",
    "sensitivity",
]


class FoundNumber(NamedTuple):
    """A number that was fitted, all in SI.

    `low` and `high` are its interval: by its profile where it has one, else linear about the best fit.
    `experiment` is "" for a number of all experiments. `at_bound`: it ended there, where
    its interval ends as well; `std` is then that of all numbers left free.
    """

    key: str
    experiment: str
    unit: str
    start: float
    value: float
    std: float
    low: float
    high: float
    at_bound: bool


class Fit(Drawn):
    """What a fit has found.

    Attributes:
        numbers: the fitted numbers by name: the key, with " [EXPERIMENT]" behind it where every
            experiment has its own.
        choices: the same data with the other laws of the file, by name.
    """

    def __init__(self, fitted: Fitted, choices: Mapping[str, Fitted] | None = None) -> None:
        self._fitted: Fitted = fitted
        self.choices: dict[str, Fit] = {name: Fit(f) for name, f in (choices or {}).items()}
        self.numbers: dict[str, FoundNumber] = _numbers(fitted)

    def __getitem__(self, name: str) -> FoundNumber:
        """A fitted number by its name."""
        return self.numbers[name]

    @property
    def converged(self) -> bool:
        """Whether the best search came to its end, with no run failed there."""
        return self._fitted.converged

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance (n, n) of the numbers, in their order and SI; inf where nothing is told."""
        return self._fitted.certainty.covariance

    @property
    def correlation(self) -> NDArray[np.float64]:
        """Correlation (n, n) of the numbers."""
        return self._fitted.certainty.correlation

    @property
    def aic(self) -> float:
        """Akaike's criterion, to compare with that of `choices`."""
        return self._fitted.criteria.aic

    @property
    def bic(self) -> float:
        """The Bayesian criterion, to compare with that of `choices`."""
        return self._fitted.criteria.bic

    @property
    def remarks(self) -> list[str]:
        """What the data say and do not say, in words."""
        from lumpedcable.fitting.remarks import remarks_of

        return remarks_of(self._fitted)

    def report(self) -> None:
        """Print what `lumpedcable fit` prints."""
        from lumpedcable.fitting.report import print_fit

        print_fit(self._fitted, self._others())

    def contents(self) -> dict[str, Any]:
        """All that `fit.json` holds: data and model, profiles, searches, draws."""
        from lumpedcable.fitting.report import contents_of

        return contents_of(self._fitted)

    def save(self, folder: str | Path) -> list[Path]:
        """Write the fitted scene (ready for `run`) and fit.json, and return the files made.

        Warns where the fitted scene cannot be run as it is.

        Raises:
            OutputError: they cannot be written there.
        """
        from lumpedcable.fitting.write import write_fit

        made, wrong = write_fit(self._fitted, self._others(), Path(folder))
        for message in wrong:
            warnings.warn(f"the fitted scene cannot be run as it is: {message}", stacklevel=2)
        return made

    def figures(self) -> Figures:
        """The figures of `lumpedcable fit`: data and model, correlations, laws, profiles."""
        from lumpedcable.view import fit_figures

        return Figures(fit_figures(self._pictures()))

    def _drawn(self, folder: Path, formats: Sequence[str]) -> list[Path]:
        from lumpedcable.view import plot_fit

        return plot_fit(self._pictures(), folder, formats)

    def _pictures(self) -> FitPictures:
        from lumpedcable.fitting.write import pictures_of
        from lumpedcable.view.fit import pictures_from

        return pictures_from(pictures_of(self._fitted))

    def _others(self) -> dict[str, Fitted]:
        return {name: other._fitted for name, other in self.choices.items()}

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {n.value:.6g}" for name, n in self.numbers.items())
        return f"Fit({found}; {'converged' if self.converged else 'not converged'})"


def _numbers(fitted: Fitted) -> dict[str, FoundNumber]:
    """The fitted numbers by name."""
    sure, found = fitted.certainty, {}
    for k, p in enumerate(fitted.problem.parameters):
        found[p.name] = FoundNumber(
            p.key, p.experiment or "", p.unit, p.start, float(fitted.values[k]),
            float(sure.std[k]), float(sure.low[k]), float(sure.high[k]), fitted.at_bound[k],
        )  # fmt: skip
    return found


def fit(file: str | Path) -> Fit:
    """Find numbers of a scene from measurements, as `lumpedcable fit` does.

    Args:
        file: fit file (TOML): a scene, its free numbers, experiments with their data.

    Returns:
        The fit. A search that came to no end is no error; `converged` and `remarks` tell of it.

    Raises:
        SceneError: the file, its scene or its data are wrong; the message lists every fault.
        ResultError: it asks for draws, and the sampler is not installed.
        ValueError: it names several ropes, see `fit_ropes`.
    """
    from lumpedcable.fitting.load import load_fit
    from lumpedcable.fitting.whole import fit_study

    study = load_fit(Path(file))
    if study.ropes:
        raise ValueError(f"{file}: expected one rope, found {len(study.ropes)}: use fit_ropes")
    return Fit(*fit_study(study))


def fit_ropes(file: str | Path) -> dict[str, Fit]:
    """The fits of a file that names ropes, all at once (one a lane), by rope.

    Raises:
        SceneError: the file, its scene or its data are wrong; the message lists every fault.
        ValueError: it names no ropes, see `fit`.
    """
    from lumpedcable.fitting.load import load_fit
    from lumpedcable.fitting.ropes import fit_ropes as fitted_ropes

    study = load_fit(Path(file))
    if not study.ropes:
        raise ValueError(f"{file}: expected ropes, found none: use fit")
    return {name: Fit(fitted) for name, fitted in fitted_ropes(study.ropes).items()}


class Dependence(NamedTuple):
    """How a result depends on one number of the scene: d(result)/d(number), both in SI.

    `share` is per cent of the result per per cent of the number, 0 where the number is 0.
    """

    key: str
    unit: str
    value: float
    derivative: float
    share: float


class Sensitivity(Drawn):
    """What one scalar of a run depends on.

    Attributes:
        title: the scene's title, and which run of its sweep this is.
        result: the scalar in words, "max velocity at rope.end".
        value, unit: the scalar, in SI.
        status: how the run ended: "ok", or a word for what went wrong.
        numbers: what it depends on by key, the largest share first.
    """

    def __init__(self, title: str, found: Slopes) -> None:
        self._found: Slopes = found
        self.title: str = title
        self.result: str = str(found.scalar)
        self.value: float = found.value
        self.unit: str = found.scalar.unit
        self.status: str = found.status.name.lower()
        columns = zip(
            found.keys, found.units, found.values, found.slopes, found.shares, strict=True
        )
        self.numbers: dict[str, Dependence] = {
            key: Dependence(key, unit, float(x), float(slope), float(share))
            for key, unit, x, slope, share in columns
        }

    @property
    def remarks(self) -> list[str]:
        """What is to be known of the derivatives, in words."""
        return self._found.remarks

    def __getitem__(self, key: str) -> Dependence:
        """How it depends on a number, by its key."""
        return self.numbers[key]

    def report(self) -> None:
        """Print what `lumpedcable sensitivity` prints."""
        from lumpedcable.fitting.report import print_sensitivity

        print_sensitivity(self.title, self._found)

    def save(self, folder: str | Path) -> list[Path]:
        """Write sensitivity.json, and return the files made.

        Raises:
            OutputError: it cannot be written there.
        """
        from lumpedcable.fitting.report import slopes_contents
        from lumpedcable.results.numbers import write_numbers

        target = Path(folder) / "sensitivity.json"
        write_numbers(target, slopes_contents(self.title, self._found))
        return [target]

    def figures(self) -> Figures:
        """The bars of `lumpedcable sensitivity`."""
        from lumpedcable.view import sensitivity_bars

        return Figures(sensitivity=sensitivity_bars(**self._bars()))

    def _drawn(self, folder: Path, formats: Sequence[str]) -> list[Path]:
        from lumpedcable.view import plot_sensitivity

        return plot_sensitivity(**self._bars(), stem=folder / "sensitivity", formats=formats)

    def _bars(self) -> dict[str, Any]:
        """What its picture shows, as the functions that draw it take it."""
        heading, note = f"{self.title}: {self.result}", " ".join(self.remarks)
        return {
            "heading": heading, "names": self._found.labels, "shares": self._found.shares,
            "note": note,
        }  # fmt: skip

    def __repr__(self) -> str:
        first = next(iter(self.numbers), "no number")
        return f"Sensitivity({self.result} = {self.value:.6g} {self.unit}; most of all on {first})"


def sensitivity(
    scene: str | Path,
    of: str | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    run: int = 0,
    **more: Any,
) -> Sensitivity:
    """Derivatives of one scalar of a run by every number of the scene's physics.

    Args:
        scene: scene file (TOML).
        of: the scalar, "max velocity at rope.end" or a measure of the scene, "min h_w"; None for
            what `lumpedcable sensitivity` takes.
        changes: other values by key, as in `run`.
        run: which run of a sweep, from 0.
        more: changes whose key is one word.

    Raises:
        SceneError: the scene or a change is wrong, or the scene has no such scalar.
        ValueError: the scene has no such run.
    """
    study = study_with_run(scene, changes, more, run)
    return study_sensitivity(study, of, run)


def response(
    scene: str | Path,
    by: Sequence[str],
    of: str | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    run: int = 0,
    spare: float = 0.0,
    **more: Any,
) -> Response:
    """A number of a run as a function of numbers of its scene, to be differentiated and batched by jax.

    What it computes are statics and every step of the run, in the precision of the scene.

    Args:
        scene: scene file (TOML).
        by: keys of the numbers, or their ends where one number alone has that end, as in `run`.
        of: the number of the run, as in `sensitivity`.
        changes: other values by key, as in `run`.
        run: which run of a sweep, from 0.
        spare: a share of steps more than the scene's own numbers ask for: 0.5 for x at which waves are
            up to half as fast again. Derivatives want a number of steps that does not change.
        more: changes whose key is one word.

    Returns:
        f with f(x) the number in SI for x in SI, shape (n,), and its first derivatives; `jax.grad` of it
        takes a method of fixed steps, `jax.jacfwd` any.

    Raises:
        SceneError: the scene or a change is wrong.
        ValueError: the scene has no such number, no such result or no such run, `spare` is no share, or
            the run would take more steps than anybody waits for.
    """
    from lumpedcable.fitting.response import Response

    study = study_with_run(scene, changes, more, run)
    return Response(study, of, by, run, spare)


def study_sensitivity(study: Study, of: str | None, run: int) -> Sensitivity:
    """The same of a run of a study that is loaded.

    Raises:
        SceneError: the scene cannot be laid out, or has no such scalar.
    """
    from lumpedcable.fitting.scalar import asked_scalar
    from lumpedcable.fitting.sensitivity import sensitivity_of
    from lumpedcable.study.modes_report import heading

    scalar = asked_scalar(study, of, run)
    return Sensitivity(heading(study, run), sensitivity_of(study, scalar, run))
