"""Lines that are joined rigidly bend as one over the joint, until one of them breaks away."""

import numpy as np
import pytest
from engine_runs import (
    STEEL,
    equilibrium_of,
    fixed,
    line_text,
    nodes_in_space,
    order_of,
    run_text,
    scene_of,
)
from modal_runs import modes_of

GRAVITY, LENGTH, MASS, EI, PART = 9.81, 2.0, 0.5, 100.0, 0.8
WEIGHT = f"gravity = {GRAVITY}"
WALL = "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"
DOWN = "{ held = { pretension = 3, direction = [0, 0, -1] } }"
LET_GO = '[events.tip]\nbreaks = "{}"\ntime = "5 ms"\n'


def bends(stiffness=EI):
    return f"bending = {{ EI = {stiffness} }}"


def rigid(end):
    return f'{{ joined = "{end}", rigid = true }}'


def whole(tip='"free"', segments=20, gravity=WEIGHT, wall=WALL):
    rod = line_text("rod", "steel", LENGTH, segments, MASS, wall, tip, bends())
    return STEEL.format(more=gravity) + rod


def joined(tip='"free"', segments=20, gravity=WEIGHT, wall=WALL, outer=EI, turned=False):
    """The same out of two lines, of which the outer one may run inwards, and bend otherwise."""
    split = round(segments * PART / LENGTH)
    ends = (tip, rigid("in.end")) if turned else (rigid("in.end"), tip)
    inner = line_text("in", "steel", PART, split, MASS, wall, '"free"', bends())
    rest = line_text("out", "steel", LENGTH - PART, segments - split, MASS, *ends, bends(outer))
    return STEEL.format(more=gravity) + inner + rest


def together(inner, outer, turned=False):
    """Nodes (..., n, 3) of both lines as those of one."""
    return np.concatenate([inner, (outer[..., ::-1, :] if turned else outer)[..., 1:, :]], axis=-2)


def at_rest(folder, text, *names):
    found, coordinates = equilibrium_of(scene_of(folder, text))
    assert bool(found.converged)
    return [nodes_in_space(found, coordinates, name).T for name in names]


@pytest.mark.parametrize("turned", [pytest.param(False, marks=pytest.mark.slow), True])
def test_two_lines_rest_as_one(tmp_path, turned):
    (alone,) = at_rest(tmp_path, whole(DOWN), "rod")
    both = at_rest(tmp_path, joined(DOWN, turned=turned), "in", "out")
    np.testing.assert_allclose(together(*both, turned), alone, atol=1e-11)
    assert alone[-1, 2] < -0.1


@pytest.mark.slow
@pytest.mark.parametrize("gap", [0.05, 1.5])
def test_three_lines_hang_as_one_between_two_places(tmp_path, gap):
    """In a loop as open as bending asks for, and nearly straight; the middle one runs back."""
    places, lengths = (fixed(0, 0, 0), fixed(gap, 0, -0.1)), (0.4, 0.6, 1.0)
    rod = line_text("rod", "steel", LENGTH, 20, MASS, *places, bends(2.0))
    (alone,) = at_rest(tmp_path, STEEL.format(more=WEIGHT) + rod, "rod")
    ends = (
        (places[0], '"free"'),
        (rigid("c.start"), rigid("a.end")),
        ('"free"', places[1]),
    )
    text = STEEL.format(more=WEIGHT)
    for name, length, pair in zip("abc", lengths, ends, strict=True):
        text += line_text(name, "steel", length, round(10 * length), MASS, *pair, bends(2.0))
    a, b, c = at_rest(tmp_path, text, *"abc")
    np.testing.assert_allclose(together(together(a, b, True), c), alone, atol=1e-9)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.slow
def test_two_lines_move_as_one(tmp_path, turned):
    alone = run_text(tmp_path, whole(DOWN) + LET_GO.format("rod.end"))
    tip = "out.start" if turned else "out.end"
    both = run_text(tmp_path, joined(DOWN, turned=turned) + LET_GO.format(tip))
    assert both.statuses == alone.statuses == ["OK"]
    moved = together(both["in.position"][0], both["out.position"][0], turned)
    np.testing.assert_allclose(moved, alone["position"][0], atol=1e-11)
    assert np.ptp(alone["position"][0, :, -1, 2]) > 0.01
    np.testing.assert_allclose(both.energy["bending"], alone.energy["bending"], rtol=1e-9)


def test_two_lines_swing_as_one(tmp_path):
    alone = modes_of(tmp_path, whole(), count=5).frequency
    np.testing.assert_allclose(modes_of(tmp_path, joined(), count=5).frequency, alone, rtol=1e-8)


@pytest.mark.parametrize("outer", [20.0, pytest.param(1000.0, marks=pytest.mark.slow)])
def test_a_stepped_cantilever_bends_as_a_beam(tmp_path, outer):
    """Its tip goes by F int x^2 / EI dx, x from the tip, and the moment at the joint is F x."""
    force, errors = 3e-3, []
    tip = f"{{ held = {{ pretension = {force}, direction = [0, 0, -1] }} }}"
    rest = LENGTH - PART
    exact = force / 3.0 * (rest**3 / outer + (LENGTH**3 - rest**3) / EI)
    for segments in (10, 20, 40):
        text = joined(tip, segments, gravity="", outer=outer)
        (_, nodes) = at_rest(tmp_path, text, "in", "out")
        errors.append(abs(-nodes[-1, 2] / exact - 1.0))
    assert errors[-1] < 2e-3
    np.testing.assert_allclose(order_of(errors, (2.0, 2.0)), 2.0, atol=0.1)
    told = run_text(
        tmp_path, text, 'output.quantities=["bending_moment"]', "output.duration=0.0025"
    )
    for name, node in (("in", -1), ("out", 0)):
        moment = told[f"{name}.bending_moment"][0, 0, node]
        assert moment == pytest.approx(force * rest, rel=1e-5)


@pytest.mark.parametrize(("over", "share"), [(rigid("in.end"), 0.125), ('"in.end"', 0.0)])
def test_a_beam_on_three_supports(tmp_path, over, share):
    """The moment over the middle one is w L^2 / 8, L the span; 0 over a hinge."""
    length, stiffness = 2.0, 1e4
    text = STEEL.format(more=WEIGHT)
    text += line_text(
        "in", "steel", length, 20, MASS, fixed(0, 0, 0), fixed(length, 0, 0), bends(stiffness)
    )
    text += line_text(
        "out", "steel", length, 20, MASS, over, fixed(2 * length, 0, 0), bends(stiffness)
    )
    told = run_text(
        tmp_path, text, 'output.quantities=["bending_moment"]', "output.duration=0.0025"
    )
    wanted = share * MASS * GRAVITY * length**2
    for name, node in (("in", -1), ("out", 0)):
        moment = told[f"{name}.bending_moment"][0, 0, node]
        assert moment == pytest.approx(wanted, rel=5e-3, abs=1e-9)


@pytest.mark.parametrize("time", [0.004, 0])
@pytest.mark.slow
def test_a_break_at_the_joint_is_one_of_the_line(tmp_path, time):
    begins = f"time = {time}\nstart = 0.0301\n"
    let_go = LET_GO.format("rod.end") + f'[events.cut]\nbreaks = "rod@{PART} m"\n{begins}'
    alone = run_text(tmp_path, whole(DOWN) + let_go)
    let_go = LET_GO.format("out.end") + f'[events.cut]\nbreaks = "out.start"\n{begins}'
    both = run_text(tmp_path, joined(DOWN) + let_go)
    assert both.statuses == alone.statuses == ["OK"]
    for name, part in (("in", "rod-1"), ("out", "rod-2")):
        place = alone[f"{part}.position"][0]
        np.testing.assert_allclose(both[f"{name}.position"][0], place, atol=1e-10)
    apart = both["in.position"][0, :, -1] - both["out.position"][0, :, 0]
    assert np.abs(apart[both.time < 0.03]).max() < 1e-12
    assert np.linalg.norm(apart[-1]) > 0.01
    closures = [ran.outcomes[0].energy_closure for ran in (both, alone)]
    assert closures[0] == pytest.approx(closures[1], rel=1e-6)


def test_a_beam_shaken_at_its_clamp_answers_as_a_beam_does(tmp_path):
    """Its tip goes (cos b + cosh b) / (1 + cos b cosh b) times as far, b^4 = m w^2 L^4 / EI."""
    b, size = 1.4, 1e-3
    period = 2.0 * np.pi * (LENGTH / b) ** 2 * np.sqrt(MASS / EI)
    path = f"amplitude = [0, 0, {size}], period = {period}, ramp = {6 * period}"
    wall = f"{{ motion = {{ position = [0, 0, 0], {path} }}, direction = [1, 0, 0] }}"
    output = f"output.duration={8 * period}", f"output.every={period / 8}"
    ran = run_text(tmp_path, whole(gravity="", wall=wall), *output)
    assert ran.statuses == ["OK"]
    last = slice(-8, None)
    turn = 2.0 * np.pi * ran.time[last] / period
    tip = ran["position"][0, last, -1, 2]
    share = np.mean(tip * np.sin(turn)) * 2.0 / size
    assert share == pytest.approx(
        (np.cos(b) + np.cosh(b)) / (1.0 + np.cos(b) * np.cosh(b)), rel=0.01
    )
    assert abs(np.mean(tip * np.cos(turn))) < 0.01 * size


@pytest.mark.slow
def test_both_lines_tell_the_tension_at_their_joint(tmp_path):
    """It is F . t, F what hangs beyond the joint and t the direction there."""
    below = 3.0 + MASS * GRAVITY * (LENGTH - PART)
    errors = []
    for segments in (20, 40, 80):
        told = run_text(tmp_path, joined(DOWN, segments), "output.duration=0.0025")
        ends = [told[name][0, 0] for name in ("in.end_tension", "out.start_tension")]
        across = told["out.position"][0, 0, 1] - told["in.position"][0, 0, -2]
        exact = -below * across[2] / np.linalg.norm(across)
        errors.append([end / exact - 1.0 for end in ends])
    assert np.abs(errors[-1]).max() < 2e-3
    np.testing.assert_allclose(order_of(np.abs(errors), (2.0, 2.0))[-1], 2.0, atol=0.3)


@pytest.mark.slow
def test_a_drum_pays_for_what_bends_over_a_joint_of_its_line(tmp_path):
    """The longer the line, the softer the joint: k of E = k (1 - u . w) falls as it is paid out."""
    slow = "schedule = { time = [0, 0.15], speed = [0, 1] }"
    drum = f"{{ drum = {{ at = [0, 0, 0], {slow} }} }}"
    text = STEEL.format(more=WEIGHT)
    text += line_text("in", "steel", LENGTH, 10, 2.0, drum, '"free"', bends(50.0))
    end = "{ fixed = [3.5, 0, 0.3], direction = [1, 0, 0] }"
    text += line_text("out", "steel", LENGTH, 10, 2.0, rigid("in.end"), end, bends(200.0))
    ran = run_text(tmp_path, text, "output.duration=0.5")
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-4


def test_a_cantilever_at_rest_is_at_rest_in_single_precision(tmp_path):
    """1 - u . u' of two directions has no digits left there, |u' - u|^2 / 2 has all."""
    ran = run_text(tmp_path, whole(), 'solver.dtype="float32"')
    assert ran.statuses == ["OK"]
    first = ran.energy["bending"][0, 0]
    double = run_text(tmp_path, whole()).energy["bending"][0, 0]
    assert first == pytest.approx(double, rel=2e-5)
