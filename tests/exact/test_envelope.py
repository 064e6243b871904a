"""The lower convex envelope against hand-made cases and the Legendre biconjugate."""

from itertools import pairwise

import numpy as np
import pytest
from nylon_line import tension

from lumpedcable.exact import lower_convex_envelope


def biconjugate(law, lo, hi, at, n=6001):
    """T**(e) = max_k (k e - max_x (k x - T(x))), by brute force on a grid of slopes."""
    x = np.linspace(lo, hi, n)
    slopes = np.unique(np.gradient(law(x), x))
    k = np.linspace(slopes[0], slopes[-1], n)
    conjugate = np.array([np.max(s * x - law(x)) for s in k])
    return np.array([np.max(k * e - conjugate) for e in at])


LAWS = {
    "nylon": (tension, 0.0003, 0.3),
    "convex": (lambda e: 1e5 * (e + 3 * e**2), 0.0, 0.3),
    "concave": (lambda e: 1e5 * np.sqrt(e + 0.01), 0.0, 0.3),
    "two dips": (lambda e: 1e5 * (e + e**2 + 0.02 * np.sin(40 * e)), 0.0, 0.3),
    "table": (lambda e: np.interp(e, [0, 0.1, 0.15, 0.3], [0, 1e4, 5e4, 7e4]), 0.0, 0.3),
}


@pytest.mark.parametrize("name", LAWS)
def test_against_the_biconjugate(name):
    law, lo, hi = LAWS[name]
    hull = lower_convex_envelope(law, lo, hi)
    e = np.linspace(lo, hi, 101)
    scale = float(law(hi) - law(lo))
    assert np.max(np.abs(hull.tension(e) - biconjugate(law, lo, hi, e))) < 2e-4 * scale
    assert np.all(hull.tension(e) <= law(e) + 1e-12 * scale)
    assert np.all(np.diff(hull.slope(e)) > -1e-9 * np.max(hull.slope(e)))
    # The pieces meet and fill the range.
    assert hull.pieces[0].strain_lo == lo
    assert hull.pieces[-1].strain_hi == hi
    for a, b in pairwise(hull.pieces):
        assert a.strain_hi == b.strain_lo
        assert a.slope_hi <= b.slope_lo * (1.0 + 1e-9)


def test_tangent_from_the_end_of_a_cubic():
    # T = e^3 - e on [-1, 1]: concave below 0, convex above; the chord from -1 touches at 1/2.
    hull = lower_convex_envelope(lambda e: e**3 - e, -1.0, 1.0, derivative=lambda e: 3 * e**2 - 1)
    shock, fan = hull.pieces
    assert (shock.kind, fan.kind) == ("shock", "rarefaction")
    assert shock.strain_hi == pytest.approx(0.5, abs=1e-13)
    assert shock.slope_lo == pytest.approx(-0.25, abs=1e-13)


def test_double_tangent_of_a_quartic():
    # T = (e^2 - 1)^2 + k e has the chord of slope k between -1 and 1, tangent at both ends.
    for derivative in (None, lambda e: 4 * e * (e**2 - 1) + 7.0):
        hull = lower_convex_envelope(
            lambda e: (e**2 - 1) ** 2 + 7.0 * e, -2.3, 1.9, derivative=derivative
        )
        assert [p.kind for p in hull.pieces] == ["rarefaction", "shock", "rarefaction"]
        shock = hull.pieces[1]
        assert (shock.strain_lo, shock.strain_hi) == pytest.approx((-1.0, 1.0), abs=1e-11)
        assert shock.slope_lo == pytest.approx(7.0, abs=1e-12)


def test_corner_that_nobody_announced():
    # Convex corner at pi/20 between straight parts: the chords stay on their own sides.
    corner = np.pi / 20
    hull = lower_convex_envelope(
        lambda e: np.maximum(100.0 * e, 300.0 * e - 200.0 * corner), 0, 0.3
    )
    e = np.linspace(0.0, 0.3, 1001)
    exact = np.maximum(100.0 * e, 300.0 * e - 200.0 * corner)
    assert np.max(np.abs(hull.tension(e) - exact)) < 1e-9
    known = lower_convex_envelope(
        lambda e: np.maximum(100.0 * e, 300.0 * e - 200.0 * corner), 0, 0.3, knots=[corner]
    )
    assert [p.kind for p in known.pieces] == ["contact", "contact"]
    assert [p.slope_lo for p in known.pieces] == pytest.approx([100.0, 300.0], rel=1e-12)


def test_straight_law_is_one_contact():
    for offset in (0.0, 1e6):
        (piece,) = lower_convex_envelope(lambda e, c=offset: 1e5 * e + c, -0.1, 0.4).pieces
        assert piece.kind == "contact"
        assert piece.slope_lo == pytest.approx(1e5, rel=1e-9)


def test_bad_input():
    with pytest.raises(ValueError, match="increasing range"):
        lower_convex_envelope(tension, 0.3, 0.1)
    with pytest.raises(ValueError, match="not finite"):
        lower_convex_envelope(lambda e: np.where(e > 0.2, np.inf, e), 0.0, 0.3)
