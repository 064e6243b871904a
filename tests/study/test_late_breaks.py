"""Numbers of ends that break when lines have moved: of the break alone, and from it on."""

import numpy as np
import pytest
from engine_runs import HOOKE, fixed, line_text, run_text

from lumpedcable.results import open_result

# hauled in by 4 m within 40 ms, which sends waves to and fro, until it breaks in the middle of these
HAULED = (
    HOOKE.replace(
        'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
        "end = { motion = { time = [0, 0.01, 0.02, 0.04, 0.05, 9],"
        " position = [[105, 0, 0], [105, 0, 0], [104, 0, 0], [101, 0, 0], [101, 0, 0], [101, 0, 0]] } }",
    ).replace('EA = "1 MN"', 'EA = "1 MN"\ndamping = "20 kN s"')
    + '\n[solver]\nwaves = "plain"\n'
)
SMALL = (
    "rope.segments=10", "output.duration=120 ms", "break.time=2 ms", "solver.step=0.5 ms",
)  # fmt: skip


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The line that breaks at once, after 70 ms, and after 70 ms too stiff for its steps."""
    sweep = """
[[sweep.zip]]
"events.break.start" = [0, "70 ms", "70 ms"]
"materials.hooke.EA" = ["1 MN", "1 MN", "1 GN"]
"""
    return run_text(tmp_path_factory.mktemp("late"), HAULED + sweep, *SMALL)


@pytest.mark.slow
def test_numbers_of_an_end_count_from_its_break(ran):
    found = ran.outcomes[1].recoils["rope.end"]
    place, speed = ran["position"][1, :, -1, 0], np.abs(ran["velocity"][1, :, -1, 0])
    broken = ran.time >= 70e-3
    away = np.abs(place - 101.0)
    assert (
        speed.max() > 100.0 > 90.0 > speed[broken].max()
    )  # it was hauled in faster than it recoils
    assert found["end_displacement"] == pytest.approx(away[-1], rel=1e-9)
    assert found["reach"] == pytest.approx(away[broken].max(), rel=1e-2)
    assert found["peak_end_speed"] == pytest.approx(speed[broken].max(), rel=1e-2)


def test_a_run_that_ended_before_has_none_of_a_break(ran):
    assert ran.statuses == ["OK", "OK", "STEP_BOUND_BROKEN"]
    assert not ran.outcomes[2].recoils


def line(name, start, end):
    """A line of 20 m with waves of 1000 m/s."""
    return line_text(name, "m", 20, 20, 1, start, end)


JOINED = (
    '[materials.m]\nlaw = "linear"\nEA = "1 MN"\n'
    + line("a", fixed(0, 0, 0), '"b.start"')
    + line("b", '"a.end"', fixed(42, 0, 0))
)


@pytest.mark.slow
def test_an_end_feels_no_break_of_another_line(tmp_path):
    ran = run_text(
        tmp_path,
        JOINED
        + """
[events]
first = { breaks = "b.end", start = "3 ms", time = "0.5 ms" }
second = { breaks = "a.start", start = "15 ms", time = "0.5 ms" }
[output]
duration = "60 ms"
every = "1 ms"
quantities = ["position"]
""",
    )
    found = ran.outcomes[0].recoils
    # 20 m at 1000 m/s, less the foot of a front over two segments
    assert found["b.end"]["front_arrival"] == pytest.approx(20e-3, abs=2e-3)
    # at the joint the first is 8 ms after the second began 20 m away
    assert np.isnan(found["a.start"]["front_arrival"])


@pytest.mark.slow
def test_the_other_end_of_a_line_that_is_to_break_along_it_recoils(tmp_path):
    ran = run_text(
        tmp_path,
        JOINED
        + """
[events]
first = { breaks = "a.end", start = "1 ms", time = "0.5 ms" }
second = { breaks = "b@8 m", start = "25 ms", time = "0.5 ms" }
[output]
duration = "26 ms"
every = "1 ms"
quantities = ["velocity"]
[solver]
waves = "plain"
""",
    )
    for end in ("a.end", "b.start"):  # which are 20 m of line each until then
        exact = ran.outcomes[0].recoils[end]["exact_front_arrival"]
        assert exact == pytest.approx(20e-3, rel=1e-9)
    # in the file it is an end of the part before the break, that moves at T / (m c)
    with open_result(tmp_path / "result.h5") as found:
        speed = found.line("b-1").field("start_velocity")[0, 3:20, 0]
    assert np.mean(speed) == pytest.approx(50.0, rel=0.01)


@pytest.mark.slow
def test_an_end_feels_no_break_before_its_waves_can_be_there(tmp_path):
    # the start is shaken: what it carries falls by 15 % in the 10 ms after the break, 100 m away
    moves = "{ motion = { position = [0, 0, 0], amplitude = [0.05, 0, 0], period = '40 ms' } }"
    text = HOOKE.replace("start = { fixed = [0, 0, 0] }", f"start = {moves}")
    ran = run_text(tmp_path, text, "break.start=21 ms", "rope.segments=20", "output.duration=60 ms")
    pulled = ran["start_tension"][0, [0, 21, 31]]
    assert pulled[1] > 1.1 * 50e3 > 1.05 * 50e3 > pulled[2]
    assert np.isnan(ran.outcomes[0].recoils["rope.end"]["front_arrival"])


def test_the_foot_that_a_chain_has_ahead_of_a_front_is_felt(tmp_path):
    # half a per cent of the front, which the wall doubles, is 2.8 (n / 8)^(1/3) segments ahead
    options = ("rope.segments=100", "output.duration=110 ms", "solver.courant=0.1")
    ran = run_text(tmp_path, HOOKE + '\n[solver]\nwaves = "plain"\n', *options)
    felt = ran.outcomes[0].recoils["rope.end"]["front_arrival"]
    assert felt == pytest.approx((100 - 2.8 * 12.5 ** (1 / 3)) * 1e-3, abs=0.5e-3)


@pytest.mark.slow
def test_one_segment_has_no_far_end_and_two_have_that_of_their_chain(tmp_path):
    options = (
        "rope.segments=1",
        "output.duration=160 ms",
        "break.time=0 ms",
        "solver.step=0.02 ms",
    )
    text = HOOKE + '\n[solver]\nwaves = "plain"\n'
    alone = run_text(tmp_path, text, *options)
    assert np.isnan(alone.outcomes[0].recoils["rope.end"]["front_arrival"])
    # Two segments of 50 m and 1000 m/s, 50 ms in each; half a mass at the broken end. The chain from
    # there, in these units: u'' = 2 - 2 (u - v), v'' = u - 2 v, of squared frequencies 2 -+ sqrt(2).
    # The wall reads 9/8 of its segment's tension, 1 - v, less 1/8 of the other's, 1 - u + v.
    time = np.linspace(0.0, 3.0, 300_001)
    slow, fast = np.sqrt(2.0 - np.sqrt(2.0)), np.sqrt(2.0 + np.sqrt(2.0))
    v = 1.0 - (fast**2 * np.cos(slow * time) - slow**2 * np.cos(fast * time)) / (fast**2 - slow**2)
    u = 2.0 * v + (np.cos(slow * time) - np.cos(fast * time)) / np.sqrt(2.0)  # v'' + 2 v
    arrival = 50e-3 * time[np.argmax(9.0 * (1.0 - v) - (1.0 - u + v) < 8.0 * 0.99)]
    both = run_text(tmp_path, text, "rope.segments=2", *options[1:])
    felt = both.outcomes[0].recoils["rope.end"]["front_arrival"]
    assert felt == pytest.approx(arrival, rel=2e-3)


@pytest.mark.slow
def test_the_account_closes_while_a_line_breaks_away_from_a_body_that_moves(tmp_path):
    # the body is held back over half a metre: by 10 kN on average, as the line's end is pulled on
    ran = run_text(
        tmp_path,
        f"""
[materials.m]
law = "linear"
EA = "1 MN"
{line_text("rope", "m", 10, 5, 1, fixed(0, 0, 0), '"bob"')}
[bodies.bob]
mass = "600 kg"
position = [10.2, 0, 0]
velocity = [5, 0, 0]
size = [1, 1, 1]
[events.break]
breaks = "rope.end"
start = "2 ms"
time = "100 ms"
[solver]
step = "0.25 ms"
[output]
duration = "150 ms"
every = "2 ms"
""",
    )
    assert ran.statuses == ["OK"]
    kinetic = 300.0 * np.sum(ran.bodies["bob"]["velocity"][0] ** 2, axis=-1)
    assert kinetic[0] - kinetic[-1] > 4e3
    assert ran.outcomes[0].energy_closure < 1e-3


PULLED = "{ motion = { position = [20, 0, 0], velocity = [8, 0, 0] } }"


@pytest.mark.slow
def test_ways_are_counted_from_the_instant_of_the_break(tmp_path):
    # its end goes on at 8 m/s until then, which is at a step, or between two of them
    starts = np.array([0.06, 0.0649, 0.1, 0.0999, 0.15])
    text = f"""
[materials.wire]
law = "linear"
EA = "100 kN"
{line_text("rope", "wire", 19, 6, 2, "{ fixed = [0, 0, 0] }", PULLED)}
[events.break]
breaks = "rope.end"
time = "2 ms"
start = 0
[output]
duration = "0.2 s"
every = "10 ms"
[sweep]
"events.break.start" = {starts.tolist()}
"""
    ran = run_text(tmp_path, text)
    gone = np.abs(ran["position"][:, -1, -1, 0] - 20.0 - 8.0 * starts)
    for outcome, expected in zip(ran.outcomes, gone, strict=True):
        assert outcome.recoils["rope.end"]["end_displacement"] == pytest.approx(expected, rel=1e-9)
        assert outcome.recoils["rope.end"]["reach"] == pytest.approx(expected, rel=1e-9)
