"""How sure numbers are that were found with a loss that forgives: Huber's formula, worked out here."""

import numpy as np
import pytest
from fit_files import fit_of
from scipy import optimize, stats

from lumpedcable.fitting.profile import with_profiles
from lumpedcable.fitting.run import fit_problem

SCENE = """
[materials.rope]
law = "polynomial"
coefficients = ["1 MN", "2 MN"]

[lines.rope]
material = "rope"
length = "10 m"
segments = 2
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "1 kN", direction = [1, 0, 0] } }

[output]
duration = "1 ms"
every = "1 ms"
"""
FIT = """
scene = "scene.toml"
[free]
"materials.rope.coefficients" = {{}}
[experiments.bench]
material = "rope"
file = "bench.csv"
strain = {{ column = "e" }}
tension = {{ column = "T" }}
noise = "2 kN"
[method]
loss = "{loss}"
"""
NOISE, C, POINTS = 2e3, 1.5, 40
E = np.linspace(0.01, 0.3, POINTS)
X = np.stack([E, E**2], axis=1) / NOISE


def measured(outliers):
    """Tensions (N), every fifth off by eight standard deviations if there are outliers."""
    random = np.random.default_rng(3)
    load = 1e6 * E + 2e6 * E**2 + NOISE * random.standard_normal(POINTS)
    if outliers:
        load[::5] += NOISE * 8.0 * random.standard_normal(load[::5].size)
    return load


def fitted(folder, loss, load, text="", scene=SCENE):
    rows = [f"{e!r},{t!r}" for e, t in zip(E.tolist(), load.tolist(), strict=True)]
    (folder / "bench.csv").write_text("e,T\n" + "\n".join(rows) + "\n")
    return fit_problem(fit_of(folder, text or FIT.format(loss=loss), scene).problem)


def rho(r, loss):
    if loss == "huber":
        return np.where(np.abs(r) <= C, r**2, 2.0 * C * np.abs(r) - C**2)
    return C**2 * np.log1p((r / C) ** 2)


def by_hand(r, loss):
    """The mean of psi' and the root of K^2 sum psi^2/(n - p), by differences of rho."""
    h = 1e-4
    psi = (rho(r + h, loss) - rho(r - h, loss)) / (4.0 * h)
    slope = (rho(r + h, loss) - 2.0 * rho(r, loss) + rho(r - h, loss)) / (2.0 * h**2)
    k = 1.0 + 2.0 / POINTS * np.var(slope) / np.mean(slope) ** 2
    return np.mean(slope), k * np.sqrt(np.sum(psi**2) / (POINTS - 2))


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_what_is_predicted_is_so_at_the_values_found(tmp_path, loss):
    found = fitted(tmp_path, loss, measured(outliers=True))
    assert found.predicted[0] / NOISE == pytest.approx(X @ found.values, rel=1e-12)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_intervals_among_outliers_are_those_of_hubers_formula(tmp_path, loss):
    load = measured(outliers=True)
    found = fitted(tmp_path, loss, load)
    # at the end of the search, which is a thousandth of a standard deviation off the best values
    r = X @ found.values - load / NOISE
    m, root = by_hand(r, loss)
    covariance = (root / m) ** 2 * np.linalg.inv(X.T @ X)
    assert found.certainty.covariance == pytest.approx(covariance, rel=5e-3)
    half = stats.norm.ppf(0.975) * np.sqrt(np.diag(covariance))
    assert found.certainty.high - found.values == pytest.approx(half, rel=5e-3)
    # wider than where all deviations count as if they were noise of the size that was given
    assert root / m > 1.1

    # the profile rises by v/m times what a sum of squares would
    def least(x):
        line = load / NOISE - x * X[:, 0]
        return optimize.minimize_scalar(
            lambda y: np.sum(rho(y * X[:, 1] - line, loss)), bracket=(1e6, 3e6), tol=1e-12
        ).fun

    best = np.sum(rho(r, loss))
    reach = stats.norm.ppf(0.975) ** 2 * root**2 / m
    edges = [
        optimize.brentq(lambda x: least(x) - best - reach, found.values[0] + side * half[0] / 3,
                        found.values[0] + side * half[0] * 3)
        for side in (-1, 1)
    ]  # fmt: skip
    (profile,) = with_profiles(found, [0]).profiles
    assert [profile.low, profile.high] == pytest.approx(edges, abs=1e-2 * half[0])


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_number_at_its_bound_is_none_that_was_found(tmp_path, loss):
    """The cubic part of a load that has less than none of it: two numbers are left to be found."""
    load = measured(outliers=True) - 1e6 * E**3
    text = FIT.format(loss=loss).replace(" = {}", ' = { low = "0 N" }')
    scene = SCENE.replace('"2 MN"]', '"2 MN", "1 MN"]')
    found = fitted(tmp_path, loss, load, text, scene)
    assert found.at_bound == (False, False, True)
    X3 = np.append(X, E[:, None] ** 3 / NOISE, axis=1)
    m, root = by_hand(X3 @ found.values - load / NOISE, loss)
    covariance = (root / m) ** 2 * np.linalg.inv(X.T @ X)
    assert found.certainty.covariance[:2, :2] == pytest.approx(covariance, rel=5e-3)


def test_without_outliers_they_are_those_of_the_noise_given(tmp_path):
    # Huber's variance over that of squares for normal noise, in closed form: psi^2 over psi' squared
    load = 1e6 * E + 2e6 * E**2
    found = fitted(tmp_path, "huber", load)
    inner = 2.0 * stats.norm.cdf(C) - 1.0
    square = inner - 2.0 * C * stats.norm.pdf(C) + 2.0 * C**2 * stats.norm.sf(C)
    covariance = square / inner**2 * np.linalg.inv(X.T @ X)
    assert found.certainty.covariance == pytest.approx(covariance, rel=1e-5)
    squares = fitted(tmp_path, "squares", load)
    assert squares.certainty.covariance == pytest.approx(np.linalg.inv(X.T @ X), rel=1e-5)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_search_ends_at_the_minimum_however_many_values_there_are(tmp_path, loss):
    """As scipy finds it: what is left to gain counts, not its share of all that many values cost."""
    strain = np.tile(E, 50)
    random = np.random.default_rng(5)
    far = np.where(random.uniform(size=strain.size) < 0.2, 8.0, 1.0)
    load = 1e6 * strain + 2e6 * strain**2 + NOISE * far * random.standard_normal(strain.size)
    rows = [f"{e!r},{t!r}" for e, t in zip(strain.tolist(), load.tolist(), strict=True)]
    (tmp_path / "bench.csv").write_text("e,T\n" + "\n".join(rows) + "\n")
    found = fit_problem(fit_of(tmp_path, FIT.format(loss=loss), SCENE).problem)
    slope = np.stack([strain, strain**2], axis=1) * 1e6 / NOISE
    best = optimize.least_squares(
        lambda x: slope @ x - load / NOISE, [1.0, 2.0], loss=loss, f_scale=C,
        xtol=1e-14, ftol=1e-14, gtol=1e-14,
    )  # fmt: skip
    assert np.all(np.abs(found.values - 1e6 * best.x) < 1e-3 * found.certainty.std)
