"""The lightest thing that stops in time: against Coulomb's closed form, derivatives through a stop."""

import numpy as np
import pytest
from engine_runs import HOOKE, sliding_block, study_of

from lumpedcable.fitting.design import Limit, Trial, least_design, next_number, read_limit
from lumpedcable.fitting.scalar import Scalar
from lumpedcable.fitting.sensitivity import scalar_slopes
from lumpedcable.status import Status

G, MU, SPEED, VOLUME = 9.81, 0.4, 1.0, 0.4
BLOCK = sliding_block(
    speed=SPEED, face=0, volume=VOLUME, step="2 ms", duration="1.2 s", every="20 ms",
    more='stop = "block"\n',
)  # fmt: skip
KEY = "bodies.block.mass"
WAY = "last position at tow.start in x"


@pytest.mark.slow
def test_the_lightest_block_that_stops_in_time(tmp_path):
    # v^2 m / (2 mu g (m - rho V)) = d: what water carries of a lighter block lets it slide farther
    study = study_of(tmp_path, BLOCK)
    limit = read_limit(f"{WAY} <= 0.18 m", study)
    found = least_design(study, KEY, (limit,))
    share = 2.0 * MU * G * 0.18 / SPEED**2
    # a stop is found at the end of a step: an error of the second order
    assert found.value == pytest.approx(share * 1000 * VOLUME / (share - 1.0), rel=1e-5)
    assert found.trials[-1].values[0] == pytest.approx(0.18, abs=1e-6)
    # derivatives through the stop against central differences; farther apart they meet another step
    at, slope = found.trials[-1].number, found.trials[-1].slopes[0]
    errors = []
    for h in (1e-1, 1e-2, 1e-3):
        ends = [scalar_slopes(study, limit.scalar, (KEY,), [at + s * h]) for s in (1, -1)]
        assert all(status is Status.OK for _, status, _ in ends)
        errors.append(abs((ends[0][0] - ends[1][0]) / (2.0 * h) / slope - 1.0))
    assert min(errors) < 1e-6


def limits(*bounds):
    scalar = Scalar("max", "tension", "tow.start", None, "N")
    return tuple(Limit(scalar, sign, bound) for sign, bound in bounds)


def test_the_least_number_that_straight_lines_allow():
    # 10 - x / 2 <= 3 from x = 4 on asks for 14; 2 x + 1 <= 50 allows 24.5
    trial = Trial(4.0, (8.0, 9.0), (-0.5, 2.0))
    assert next_number(trial, limits((1.0, 3.0), (1.0, 50.0))) == (14.0, 0)
    # the same said as "at least"
    trial = Trial(4.0, (2.0,), (0.5,))
    assert next_number(trial, limits((-1.0, 7.0))) == (14.0, 0)
    # 2 x + 1 <= 20 allows 9.5, so far from which the lines may be bent: that is seen on the way
    trial = Trial(4.0, (8.0, 9.0), (-0.5, 2.0))
    assert next_number(trial, limits((1.0, 3.0), (1.0, 20.0))) == (14.0, 0)


@pytest.mark.parametrize(
    ("bounds", "slopes", "words"),
    [
        (((1.0, 3.0), (1.0, 8.0)), (-0.5, 2.0), "14 or more"),  # at 4 the second is broken as well
        (((1.0, 8.0), (1.0, 8.0)), (-0.5, 2.0), "4 or more"),  # or the first just kept
        (((1.0, 20.0),), (2.0,), "keeps the number from falling"),
        (((1.0, 3.0),), (0.0,), "does not"),
    ],
)
def test_limits_that_no_number_keeps_are_told(bounds, slopes, words):
    trial = Trial(4.0, (8.0, 9.0)[: len(slopes)], slopes)
    with pytest.raises(ValueError, match=words):
        next_number(trial, limits(*bounds))


def test_a_bound_that_a_limit_passes_at_its_best_is_told():
    # a line that gets longer bears less until it bears more: least at 10, where 7 are still over 3
    before = [Trial(4.0, (8.0,), (-0.5,)), Trial(10.0, (7.0,), (-0.1,))]
    with pytest.raises(ValueError, match=r"beyond it wherever tried, at best 7 at 10 \(SI\)"):
        next_number(Trial(20.0, (9.0,), (0.4,)), limits((1.0, 3.0)), before)
    # one that was kept somewhere is none such
    with pytest.raises(ValueError, match="keeps the number from falling"):
        next_number(Trial(20.0, (9.0,), (0.4,)), limits((1.0, 7.5)), before)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("max tension at tow.start", "<= 400 kN"),
        ("max tension at tow.start <= 3 m", "N"),
        ("max tension at row.start <= 3 N", None),
    ],
)
def test_limits_that_cannot_be_read_are_told(tmp_path, text, words):
    study = study_of(tmp_path, BLOCK)
    if words is None:
        with pytest.raises(ValueError, match="row"):
            least_design(study, KEY, (read_limit(text, study),))
        return
    with pytest.raises(ValueError, match=words):
        read_limit(text, study)


def test_a_number_that_there_is_not_is_told(tmp_path):
    study = study_of(tmp_path, BLOCK)
    limit = read_limit(f"{WAY} <= 0.18 m", study)
    with pytest.raises(ValueError, match=r"bodies\.block\.mas"):
        least_design(study, "bodies.block.mas", (limit,))


def test_a_negative_number_is_found_as_a_positive_one_is(tmp_path, monkeypatch):
    # a line of 10 m and EA = 100 kN from x to 0: T = EA (-x/10 m - 1) <= 2 kN from x = -10.2 m on
    line = HOOKE.replace("start = { fixed = [0, 0, 0] }", "start = { fixed = [-10.5, 0, 0] }")
    study = study_of(tmp_path, line)

    def slopes(study, scalar, keys, values, run):
        return 1e5 * (-values[0] / 10.0 - 1.0), Status.OK, np.array([-1e4])

    monkeypatch.setattr("lumpedcable.fitting.design.scalar_slopes", slopes)
    found = least_design(study, "lines.rope.start.fixed.0", limits((1.0, 2e3)))
    assert found.value == pytest.approx(-10.2, rel=1e-6)
    # farther off than a stride: from -60 m by halves
    study = study_of(tmp_path, line.replace("-10.5", "-60"))
    found = least_design(study, "lines.rope.start.fixed.0", limits((1.0, 2e3)))
    assert [trial.number for trial in found.trials][:3] == [-60.0, -30.0, -15.0]
    assert found.value == pytest.approx(-10.2, rel=1e-6)


# v^2 / (2 mu g) >= 3 m from 4.852219 m/s on
LAUNCH = ("last displacement at block in x >= 3 m", "max velocity at block <= {} m/s")
FAST = np.sqrt(2.0 * MU * G * 3.0)


def launched(monkeypatch, tmp_path, speed, most):
    """The design of a block that is to slide 3 m at least and is to be no faster than `most`."""

    def slopes(study, scalar, keys, values, run):
        (v,) = values
        if scalar.quantity == "velocity":
            return v, Status.OK, np.ones(1)
        return v**2 / (2.0 * MU * G), Status.OK, np.array([v / (MU * G)])

    monkeypatch.setattr("lumpedcable.fitting.design.scalar_slopes", slopes)
    study = study_of(tmp_path, BLOCK, f"bodies.block.velocity.0={speed}")
    read = tuple(read_limit(text.format(most), study) for text in LAUNCH)
    return least_design(study, "bodies.block.velocity.0", read)


# from 1 m/s the tangent asks for 12.3 m/s, from 20 m/s for 10.6; from 4 m/s for 4.94
@pytest.mark.parametrize(("speed", "most"), [(1, 7), (2, 7), (4, 7), (20, 7), (4, 4.9), (20, 4.9)])
def test_limits_that_only_their_tangents_contradict(monkeypatch, tmp_path, speed, most):
    found = launched(monkeypatch, tmp_path, speed, most)
    assert found.value == pytest.approx(FAST, rel=1e-6)
    assert found.decides == 0


@pytest.mark.parametrize("speed", [1, 4, 4.8, 20])
def test_limits_that_contradict_each_other_are_told_when_reached(monkeypatch, tmp_path, speed):
    words = r"asks for .* or more \(SI\), and another for 4\.8 or less"
    with pytest.raises(ValueError, match=words):
        launched(monkeypatch, tmp_path, speed, 4.8)
