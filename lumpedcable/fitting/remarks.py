"""What is said of a fit in plain words: how well it meets the data, and what they do not tell."""

from __future__ import annotations

import numpy as np

from lumpedcable.fitting.coarse import coarse_breaks
from lumpedcable.fitting.linear import start_faults
from lumpedcable.fitting.profile import departing, untold
from lumpedcable.fitting.run import Fitted, failure_text
from lumpedcable.fitting.seek import UNLIKELY, chance_of
from lumpedcable.fitting.uncertainty import Profile, words
from lumpedcable.scene import format_quantity

__all__ = ["read_roughly", "remarks_of"]

UNTOLD = 3.0  # relative standard deviation from which not even the size is told
MOST_PAIRS = 6
# R-hat from which chains disagree; independent draws below which they are few
MIXED, FEW = 1.02, 100
FEW_MORE = 2  # degrees of freedom up to which Student's t has no variance
ROUGH = 0.2  # of the noise: what is read between steps with less doubt than that is read well
OTHER_STARTS = "give other starts, or more of them (method.starts)"


def remarks_of(fitted: Fitted) -> list[str]:
    """Plain words: how well the data are met, what failed, and what cannot be told apart."""
    problem, certainty = fitted.problem, fitted.certainty
    said = [_quality(fitted), *start_faults(problem, fitted.began)]
    said += coarse_breaks(fitted.scene(r.study.scene, r.name) for r in problem.records)
    names = [p.label for p in problem.parameters]
    if any(fitted.stalled):
        stalled = ", ".join(np.array(names)[np.array(fitted.stalled)])
        said.append(
            f"Ended at a bound from which the loss falls inwards: {stalled}; {OTHER_STARTS}."
        )
    elif not fitted.converged and not fitted.failures:
        said.append(
            "The search did not come to its end: raise method.max_steps, or give better starts."
        )
    for name, status in fitted.failures:
        said.append(f"Without an answer at the values found: {failure_text(name, status)}.")
    held = [name for name, at_bound in zip(names, fitted.at_bound, strict=True) if at_bound]
    if held and len(held) < len(names):
        said.append(f"Held at its bound for the intervals of the others: {', '.join(held)}.")
    for one in certainty.vague():
        spread = "at all" if not one.spread < UNTOLD else f"better than {100 * one.spread:.2g} %"
        said.append(f"The data do not tell {words(one, names)} {spread}.")
    pairs = certainty.alike()
    if pairs:
        told = ", ".join(f"{names[j]} and {names[k]} ({r:+.3f})" for j, k, r in pairs[:MOST_PAIRS])
        more = f" and {len(pairs) - MOST_PAIRS} more pairs" if len(pairs) > MOST_PAIRS else ""
        said.append(f"Nearly inseparable, by their correlation: {told}{more}.")
    rough = [
        f"{s.label} {format_quantity(r, s.unit, 2)}"
        for s, r in zip(problem.series, fitted.rough, strict=True)
        if r > 0.0
    ]
    if rough:
        told = (
            "Times off the steps are interpolated by a cubic; a parabola differs by at most: "
            f"{', '.join(rough)}."
        )
        if read_roughly(fitted):
            told += ' Beside the noise that is much: shorten the steps ("solver.step" in [set]).'
        said.append(told)
    said += [words for one in fitted.profiles for words in _of_profile(fitted, one)]
    if (narrow := departing(fitted)) is not None:
        one, share = narrow
        said.append(
            f"The profile of {names[one]} is {share:.2g} times as wide as its deviation says: the loss "
            "is no parabola there, and the intervals of numbers without a profile may be as much too "
            "narrow (profile = true)."
        )
    draws = fitted.draws
    if draws is not None and not (np.all(draws.r_hat < MIXED) and np.all(draws.size > FEW)):
        said.append("The chains do not agree yet: raise sample.draws and sample.warmup.")
    more = problem.points - len(names)
    if draws is not None and not problem.known_noise and more <= FEW_MORE:
        said.append(
            f"With {more} more values than numbers and no noise given the draws scatter so far that "
            "their standard deviations mean nothing; their intervals do."
        )
    if draws is not None and draws.diverging:
        said.append(f"{draws.diverging} steps of the sampler went wrong: raise sample.accept.")
    if len(fitted.starts) > 1:
        said.append(_spread_of_starts(fitted))
    return said


def read_roughly(fitted: Fitted) -> bool:
    """Whether what is read between steps is in doubt by more than a little of the noise given."""
    noises = [np.inf if s.noise is None else s.noise for s in fitted.problem.series]
    return any(r > ROUGH * noise for r, noise in zip(fitted.rough, noises, strict=True))


def _of_profile(fitted: Fitted, profile: Profile) -> list[str]:
    """What is to be said of a profile: a better fit on the way, runs that fail."""
    said, p = [], fitted.problem.parameters[profile.parameter]
    if profile.better and profile.parameter not in untold(fitted):  # else rounding, on level ground
        said.append(f"The profile of {p.label} passes a better fit than this one: {OTHER_STARTS}.")
    for failed, word, end in zip(profile.failed, ("below", "above"), (0, -1), strict=True):
        if failed:
            said.append(
                f"Runs fail with {p.label} {word} {format_quantity(float(profile.x[end]), p.unit, 4)}, "
                "before its profile is at its limit: its interval is open there."
            )
    return said


def _quality(fitted: Fitted) -> str:
    problem, left, free = fitted.problem, fitted.certainty.factor, fitted.certainty.free
    if fitted.failures:
        return f"{problem.points} values, not all of which have an answer."
    if not free:
        text = f"{problem.points} values, no more than the numbers that they are to tell: what is left "
        text += "says nothing of the noise."
        return text if problem.known_noise else f"{text} Give the noise for intervals."
    if not problem.known_noise:
        return (
            f"{problem.points} values; what is left is {100 * left:.2g} % of the largest value of "
            "each column, taken as its noise."
        )
    chance = chance_of(free * left**2, free)
    text = f"{problem.points} values; deviations are {left:.3g} times the noise."
    if chance < UNLIKELY and problem.method.loss == "squares":
        text += (
            f" So much has a probability of {chance:.1g}: the search has missed a better minimum (see "
            "with other starts, method.starts), the scene cannot explain the data, or the noise is "
            "larger; the intervals are too narrow."
        )
    return text


def _spread_of_starts(fitted: Fitted) -> str:
    losses = np.array([start.loss for start in fitted.starts])
    near = losses <= losses.min() * (1.0 + 1e-4) + 1e-9
    ended = np.array([start.converged for start in fitted.starts])
    text = f"{np.sum(near)} of {losses.size} searches ended at this minimum"
    above, late = int(np.sum(~near & ended)), int(np.sum(~near & ~ended))
    if above:
        text += f", {'the others' if not late else above} above it"
    if late:
        text += f"; {late} had not come to an end after method.max_steps"
    text += "."
    if fitted.sampled:
        text = (
            "The first search ended badly, so that others began at the best of "
            f"{fitted.sampled} random places. {text}"
        )
    return text
