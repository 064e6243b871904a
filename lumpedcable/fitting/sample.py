"""Hamiltonian sampling of the parameters' distribution, by NumPyro (extra `sample`)."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.language import Sampling
from lumpedcable.fitting.minimise import loss
from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.transforms import Transform, to_values
from lumpedcable.fitting.uncertainty import Draws, decomposed

__all__ = ["MISSING", "can_sample", "with_sample"]

Array = NDArray[np.float64]

MISSING = 'sampling needs the extra "sample": pip install "lumpedcable[sample]"'
WIDEST = 3.0
"""Largest standard deviation, in units of the search, that sampling starts from for a number with a
bound: e^3 of its distance from it."""


def can_sample() -> bool:
    """Whether the sampler is installed."""
    return importlib.util.find_spec("numpyro") is not None


def with_sample(fitted: Fitted, sampling: Sampling) -> Fitted:
    """A fit with draws from the distribution of its parameters; without, where not all has an answer.

    The density is that of normal noise, exp(-S/2) with S the sum of squares over the noise; where the
    noise was not given it is integrated out with the density 1/s, which leaves S^(-n/2) of n values
    (Gelman et al., Bayesian Data Analysis, 3rd ed., 2013, section 3.2). Before the data every value
    between the bounds is as likely as any other. A robust loss takes the place of S. The sampler is
    NUTS (Hoffman & Gelman, J. Machine Learning Research 15, 2014), each chain from the best fit
    moved by the fit's own covariance, in coordinates that have this covariance.

    Raises:
        ImportError: NumPyro is not installed.
    """
    if fitted.failures:
        return fitted
    from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
    from numpyro.infer import MCMC, NUTS

    potential, to_z = _potential(fitted)
    count, chains = fitted.values.size, sampling.chains
    key, other = jax.random.split(jax.random.key(fitted.problem.method.seed))
    run = MCMC(
        NUTS(potential_fn=potential, target_accept_prob=sampling.accept),
        num_warmup=sampling.warmup, num_samples=sampling.draws, num_chains=chains,
        chain_method="vectorized", progress_bar=False,
    )  # fmt: skip
    begin = jax.random.normal(other, (chains, count))
    run.run(key, init_params=begin, extra_fields=("diverging", "num_steps"))
    drawn = np.asarray(run.get_samples(group_by_chain=True))
    extra = run.get_extra_fields(group_by_chain=True)
    transform = fitted.sought.arrays.transform
    values = np.asarray(jax.vmap(jax.vmap(lambda u: to_values(transform, to_z(u))))(drawn))
    half = 0.5 * fitted.problem.method.confidence
    low, high = np.quantile(values, [0.5 - half, 0.5 + half], axis=(0, 1))
    # where nothing varies, neither number means anything
    with np.errstate(all="ignore"):
        r_hat, size = split_gelman_rubin(values), effective_sample_size(values)
    return replace(
        fitted,
        draws=Draws(
            values, low, high, np.asarray(r_hat), np.asarray(size),
            int(np.sum(extra["diverging"])), int(np.sum(extra["num_steps"])),
        ),
    )  # fmt: skip


def _potential(fitted: Fitted) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Minus the logarithm of the density over coordinates u about the best fit, and z of u."""
    spec, arrays, problem = fitted.spec, fitted.sought.arrays, fitted.problem
    middle = jnp.asarray(fitted.sought.best.z)
    root = jnp.asarray(_root(fitted))

    def to_z(u):
        return middle + root @ u

    def potential(u):
        z = to_z(u)
        half = loss(spec, arrays, z)
        if not problem.known_noise:
            half = 0.5 * problem.points * jnp.log(half)
        return half - jnp.sum(_log_slope(arrays.transform, z))

    return potential, to_z


def _log_slope(t: Transform, z):
    """ln |dx/dz| less a constant: what makes equal ranges of x equally likely."""
    between = jax.nn.log_sigmoid(z) + jax.nn.log_sigmoid(-z)
    return jnp.where(t.has_low & t.has_high, between, jnp.where(t.has_low | t.has_high, z, 0.0))


def _root(fitted: Fitted) -> Array:
    """R with R R' the fit's covariance in z, cut short where a number would leave for its bound."""
    slope, t = fitted.sought.best.slope, fitted.sought.arrays.transform
    v, singular = decomposed(slope)
    s = 1.0 if fitted.problem.known_noise else fitted.certainty.factor
    reach = np.max(np.abs(v) * (t.has_low | t.has_high), axis=1, initial=0.0)
    return v.T * np.minimum(s / np.maximum(singular, 1e-6), WIDEST / np.maximum(reach, 1e-6))
