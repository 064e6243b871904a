"""The dispersion correction and the shock viscosity: where they act, and what they may not do."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.waves import Boundary, Last, ReleaseWaves

MASS, LENGTH, EA, DT = 1.3, 0.4, 5e5, 4e-4  # kg/m, m, N, s: a Courant number of 0.62
WALL = Boundary(False)
N = 12


def terms(
    tension, rate, ends=(WALL, WALL), dt=DT, corrected=True, stiffness=None, cut=False, angle=0.0
):
    tension, rate = jnp.asarray(tension, float), jnp.asarray(rate, float)
    stiffness = jnp.full(tension.shape, EA) if stiffness is None else jnp.asarray(stiffness, float)
    angle = jnp.broadcast_to(jnp.asarray(angle, float), tension.shape)
    tangent = jnp.stack([jnp.cos(angle), jnp.sin(angle)])
    found, _ = ReleaseWaves(corrected).terms(
        tension, stiffness, rate, tangent, jnp.asarray(LENGTH), jnp.asarray(MASS), ends,
        None if dt is None else jnp.asarray(dt), cut,
    )  # fmt: skip
    return found.correction, found.viscosity


@pytest.mark.slow
def test_nothing_happens_where_a_line_stretches_evenly():
    correction, viscous = terms(np.full(N, 9e3), np.full(N, 3.0))
    np.testing.assert_array_equal(viscous, 0.0)
    np.testing.assert_allclose(correction, 0.0, atol=1e-9)
    _, still = terms(np.full(N, 9e3), np.zeros(N))
    np.testing.assert_array_equal(still, 0.0)


def test_a_linear_rate_is_smooth():
    # the limiter is one for any straight line, so that second order survives
    _, viscous = terms(np.full(N, 9e3), 5.0 + 0.3 * np.arange(N))
    np.testing.assert_allclose(viscous[1:-1], 0.0, atol=1e-9)


def test_the_correction_is_the_leading_error_of_the_scheme():
    # -(1 - nu^2) / 12 times the second difference, nu the Courant number: here of a parabola
    nu2 = EA / MASS * (DT / LENGTH) ** 2
    j = np.arange(N)
    correction, _ = terms(9e3 + 7.0 * j**2, 5.0 + 0.3 * j)
    np.testing.assert_allclose(correction[1:-1], -(1 - nu2) / 12 * 14.0, rtol=1e-9)


@pytest.mark.parametrize(("left", "kind"), [(1e-9, "float64"), (1e-2, "float32")])
def test_what_rest_has_left_ahead_of_a_front_decides_nothing(left, kind):
    # statics leave velocities of some hundred rounding errors of the wave speed, of either sign; next to
    # a front of 50 m/s they must not switch the correction of what the front has pulled at
    rate, tension = np.zeros(N), np.full(N, 9e3)
    rate[-1], tension[-1] = -50.0 / LENGTH, 6e3
    found = []
    for sign in (-1.0, 1.0):
        noise = sign * left * np.random.default_rng(1).uniform(0.5, 1.0, N - 1) / LENGTH
        rate[:-1] = noise
        arrays = (jnp.asarray(x, kind) for x in (tension, np.full(N, EA), rate, np.ones((1, N))))
        numbers = (jnp.asarray(x, kind) for x in (LENGTH, MASS))
        (_, correction, viscous), _ = ReleaseWaves(True).terms(
            *arrays, *numbers, (WALL, WALL), jnp.asarray(DT, kind), False
        )
        found.append((correction, viscous))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=2.0 * MASS * left * np.sqrt(EA / MASS))
    assert abs(found[0][0][-2]) > 10.0


def test_a_step_at_courant_one_needs_no_correction():
    # leapfrog at c dt = l is exact on a linear line
    correction, viscous = terms(
        9e3 + 7.0 * np.arange(N) ** 2, np.sin(np.arange(N)), dt=LENGTH / np.sqrt(EA / MASS)
    )
    np.testing.assert_allclose(correction, 0.0, atol=1e-9)
    np.testing.assert_allclose(viscous, 0.0, atol=1e-9)


@pytest.mark.slow
def test_viscosity_resists():
    # it has the sign of the strain rate: it can only take energy
    rng = np.random.default_rng(3)
    for cut in (False, True):
        tension = np.maximum(rng.normal(size=200) * 1e4, 0.0)
        rate = rng.normal(size=200) * 30.0
        _, viscous = terms(tension, rate, stiffness=np.where(tension > 0, EA, 0.0), cut=cut)
        assert np.all(np.asarray(viscous) * rate >= 0.0)
        assert np.max(np.abs(viscous)) > 10.0


@pytest.mark.parametrize("dt", [DT, 0.2 * DT, None])
def test_viscosity_is_what_the_docstring_says_at_an_extremum(dt):
    # one segment that is stretched among resting ones: f = 1, b = 0.16 c + |D| / 2 or its bound
    rate = np.zeros(N)
    rate[5] = 20.0
    _, viscous = terms(np.full(N, 9e3), rate, dt=dt)
    c, jump = np.sqrt(EA / MASS), 20.0 * LENGTH
    b = 0.16 * c + 0.5 * jump
    if dt is not None:
        nu2 = (c * dt / LENGTH) ** 2
        b = min(b, 0.4 * (1 - nu2) * (3 - nu2) * LENGTH / (6 * dt))
    expected = np.zeros(N)
    expected[5] = MASS * b * jump
    np.testing.assert_allclose(viscous, expected, rtol=1e-12)


def test_a_change_of_sign_is_rough_but_where_a_taut_segment_shortens():
    # 1 in the middle, 2 and -1/2 beside it: phi is (2 - 1/2) / 2, or 2 (-1/2) and thus 0 if that is less
    rate = np.zeros(N)
    rate[4:7] = 2.0, 1.0, -0.5
    c, jump = np.sqrt(EA / MASS), LENGTH

    def share(sign, slack=False):
        tension, stiffness = np.full(N, 9e3), np.full(N, EA)
        if slack:
            tension[5] = stiffness[5] = 0.0
        _, viscous = terms(tension, sign * rate, stiffness=stiffness, cut=True)
        nu2 = EA / MASS * (DT / LENGTH) ** 2
        room = min(0.25, 0.3 * (1.0 - nu2)) if sign < 0.0 else 0.25
        b = room * LENGTH / DT if slack else 0.16 * c + 0.5 * jump
        return float(viscous[5]) / (MASS * b * jump * sign)

    assert share(1.0) == pytest.approx(1.0)
    assert share(-1.0) == pytest.approx((1.0 - 0.75) ** 2)
    assert share(1.0, slack=True) == share(-1.0, slack=True) == pytest.approx(1.0)


def test_a_slack_segment_evens_out_the_shortest_wave_in_one_step():
    # b = l / 4 dt on a weightless zigzag: m l dv/dt = -4 Q, and the velocity is gone after dt
    zigzag = np.where(np.arange(N + 1) % 2 == 0, 1.0, -1.0)
    rate = np.diff(zigzag) / LENGTH
    _, viscous = terms(np.zeros(N), rate, stiffness=np.zeros(N), cut=True)
    after = zigzag[1:-1] + DT * np.diff(np.asarray(viscous)) / (MASS * LENGTH)
    np.testing.assert_allclose(after, 0.0, atol=1e-12)


def test_a_slack_line_that_folds_is_left_to_fold():
    # b goes as 1 - (turn / 0.05)^2 with the turn over a segment and its neighbours
    turn = np.array([0.0, 0.0, 0.0, 0.01, 0.01, 0.03, 0.1, 0.1, 0.0, 0.0, 0.0])
    rate = np.where(np.arange(N) % 2 == 0, 1.0, -1.0)
    slack = {"stiffness": np.zeros(N), "cut": True}
    _, straight = terms(np.zeros(N), rate, **slack)
    _, folding = terms(np.zeros(N), rate, angle=np.cumsum([0.4, *turn]), **slack)
    over = 2.0 * np.sin(0.5 * np.convolve(turn, [1.0, 1.0])[[0, *range(1, N - 1), N - 1]])
    share = np.maximum(1.0 - (over / 0.05) ** 2, 0.0)
    np.testing.assert_allclose(folding, share * np.asarray(straight), atol=1e-12)
    assert np.sum(share == 0.0) == 3
    assert np.sum(share == 1.0) == 6
    # taut, it has its viscosity however it turns
    _, taut = terms(np.full(N, 9e3), rate, cut=True, angle=np.cumsum([0.4, *turn]))
    np.testing.assert_array_equal(taut, terms(np.full(N, 9e3), rate, cut=True)[1])


def test_a_line_that_cannot_push_is_not_pushed_by_the_correction():
    tension = np.where(np.arange(N) < 6, 0.0, 9e3)
    correction, _ = terms(tension, 5.0 + 0.3 * np.arange(N), cut=True)
    assert np.all(tension + np.asarray(correction) >= 0.0)
    signed, _ = terms(tension, 5.0 + 0.3 * np.arange(N))
    assert np.any(tension + np.asarray(signed) < 0.0)


class TestBoundary:
    outward = jnp.asarray([0.6, 0.8])

    def test_a_wall_mirrors_the_tension(self):
        assert float(WALL.ghost_tension(jnp.asarray(7.0), self.outward)) == 7.0
        stiff = jnp.asarray(200.0)
        last = Last(jnp.asarray([7.0]), stiff[None])
        rate = WALL.ghost_rate(jnp.asarray(7.0), stiff, self.outward, last)
        assert float(rate) == 7.0

    def test_a_load_is_the_mean_of_the_tensions_on_its_two_sides(self):
        held = Boundary(True, 10.0 * self.outward)
        assert float(held.ghost_tension(jnp.asarray(7.0), self.outward)) == pytest.approx(13.0)
        free = Boundary(True)
        assert float(free.ghost_tension(jnp.asarray(7.0), self.outward)) == -7.0

    def test_a_changing_load_gives_the_strain_rate_between_its_two_sides(self):
        # T' e_t = F_t at the end itself: 600 N/s over 200 N are 3 /s, the mean of 1 and 5
        force = 10.0 * self.outward
        fading = Boundary(True, force, force_rate=600.0 * self.outward)

        def ghost(boundary, *stiffness, cut=True):
            own = jnp.asarray(stiffness[0])
            last = Last(jnp.ones(len(stiffness)), jnp.asarray(stiffness)) if cut else None
            return float(boundary.ghost_rate(jnp.asarray(1.0), own, self.outward, last))

        assert ghost(fading, 200.0, 200.0) == pytest.approx(5.0)
        assert ghost(Boundary(True, force), 200.0, 200.0) == -1.0
        # slack segments follow no force: a few have run ahead, else the line falls slack
        assert ghost(fading, 0.0, 200.0) == -1.0
        assert ghost(fading, 0.0, 0.0) == ghost(fading, 0.0) == 1.0
        # a line that can push is never slack, whatever its stiffness
        assert ghost(fading, 0.0, 0.0, cut=False) == -1.0

    def test_a_wave_that_shortens_the_last_segments_alike_lets_the_line_fall_slack(self):
        def repeats(*rates, slack=1):
            stiffness = jnp.where(jnp.arange(5) < slack, 0.0, EA)
            last = Last(jnp.asarray(rates), stiffness)
            ghost = Boundary(True).ghost_rate(last.rate[0], stiffness[0], self.outward, last)
            assert abs(float(ghost)) == abs(rates[0])
            return float(ghost) == rates[0]

        # a fifth, a quarter and a third of the fastest
        assert repeats(-2.0, -2.5, -10 / 3, -9.0, -10.0)
        assert not repeats(-1.9, -2.5, -10 / 3, -9.0, -10.0)
        assert not repeats(-2.0, -2.4, -10 / 3, -9.0, -10.0)
        assert not repeats(-2.0, -2.5, -3.3, -9.0, -10.0)
        # an end that has run ahead of a line that does not move, or stretches
        assert not repeats(-2.0, 0.0, 0.0, 0.0, 0.0)
        assert not repeats(-2.0, 1.0, 1.0, 1.0, 1.0)
        # the end's own segment is taut yet
        assert not repeats(-10.0, -10.0, -10.0, -10.0, -10.0, slack=0)

    def test_what_breaks_is_a_wall_before_and_a_load_after(self):
        for begun in (False, True):
            breaks = Boundary(jnp.asarray(begun), None)
            fixed = free = float(breaks.ghost_tension(jnp.asarray(7.0), self.outward))
            assert (free == -7.0) if begun else (fixed == 7.0)
            stiff = jnp.asarray(200.0)
            last = Last(jnp.asarray([7.0]), stiff[None])
            rate = breaks.ghost_rate(jnp.asarray(7.0), stiff, self.outward, last)
            assert float(rate) == (-7.0 if begun else 7.0)

    def test_no_correction_at_a_joint(self):
        tension, rate = 9e3 + 7.0 * np.arange(N) ** 2, 5.0 + 0.3 * np.arange(N)
        whole, _ = terms(tension, rate)
        parted, _ = terms(tension, rate, ends=(WALL, Boundary(False, None, True)))
        np.testing.assert_array_equal(parted[:-1], whole[:-1])
        assert parted[-1] == 0.0 != whole[-1]

    @pytest.mark.parametrize("node", [0, -1])
    def test_more_viscosity_within_less_of_the_bound_at_a_loaded_end(self, node):
        # half a mass follows it; b = 3/2 (0.16 c + |D| / 2), or 0.35 of the bound
        rate = np.zeros(N)
        rate[node] = 20.0
        loaded = (Boundary(True), WALL) if node == 0 else (WALL, Boundary(True))
        c, jump = np.sqrt(EA / MASS), 20.0 * LENGTH
        for dt in (DT, 0.05 * DT):
            _, viscous = terms(np.full(N, 9e3), rate, ends=loaded, dt=dt)
            nu2 = (c * dt / LENGTH) ** 2
            bound = 0.4 * 0.35 * (1 - nu2) * (3 - nu2) * LENGTH / (6 * dt)
            free = 1.5 * (0.16 * c + 0.5 * jump)
            expected = MASS * min(free, bound) * jump
            assert float(viscous[node]) == pytest.approx(expected, rel=1e-12)
            assert (bound < free) == (dt == DT)


@pytest.mark.slow
def test_the_derivative_of_the_viscosity_is_its_differences():
    # phi is, one after the other: 1, the mean of the two ratios, that again, 1, the mean, twice the
    # right one, 0, 0, 0, twice the left one; each branch has a derivative of its own
    rate = jnp.array([0.6, 1.0, 1.7, 2.1, 1.4, 1.5, 4.0, 4.2, 0.4, -1.2, 0.3, 3.0])
    phi = [1.0, 0.5 * (1.0 + 2.1) / 1.7, 0.5 * (1.7 + 1.4) / 2.1, 1.0, 1.0,
           0.5 * (1.5 + 4.2) / 4.0, 2.0 * 0.4 / 4.2, 0.0, 0.0, 0.0]  # fmt: skip
    tension = 9e3 + 500.0 * jnp.sin(jnp.arange(N))

    def share(rate, stiff):
        b = 0.16 * jnp.sqrt(EA * stiff / MASS) + 0.5 * jnp.abs(rate) * LENGTH
        _, viscous = terms(tension, rate, dt=None, stiffness=EA * stiff)
        return viscous / (MASS * b * rate * LENGTH)

    one = jnp.ones(N)
    np.testing.assert_allclose(share(rate, one)[1:-1], (1.0 - np.array(phi)) ** 2, atol=1e-12)
    assert float(share(rate, one)[-1]) == pytest.approx((1.0 - 2.0 * 0.3 / 3.0) ** 2)

    def viscous(rate, stiff):
        return terms(tension, rate, stiffness=EA * stiff)[1]

    check_grads(jax.jit(viscous), (rate, one), 2, ["fwd", "rev"], eps=1e-6, rtol=1e-5)
