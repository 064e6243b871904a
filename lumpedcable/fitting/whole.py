"""A fit file from beginning to end: the fit, its profiles and draws, and the other laws."""

from __future__ import annotations

from typing import NamedTuple

from lumpedcable.fitting.load import FitStudy
from lumpedcable.fitting.profile import with_profiles
from lumpedcable.fitting.run import Fitted, fit_problem
from lumpedcable.fitting.sample import MISSING, can_sample, with_sample
from lumpedcable.results.errors import ResultError

__all__ = ["Whole", "fit_study"]


class Whole(NamedTuple):
    """What a fit file asks for: the fit, and the same data with other laws by name."""

    fitted: Fitted
    choices: dict[str, Fitted]


def fit_study(study: FitStudy) -> Whole:
    """Everything that a fit file of one rope asks for.

    Raises:
        ResultError: it asks for draws, and the sampler is not installed; nothing is computed then.
    """
    if study.sampling is not None and not can_sample():
        raise ResultError(f"{study.path}: {MISSING}")
    fitted = with_profiles(fit_problem(study.problem))
    if study.sampling is not None:
        fitted = with_sample(fitted, study.sampling)
    return Whole(fitted, {name: fit_problem(problem) for name, problem in study.choices.items()})
