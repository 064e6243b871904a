"""A line with bending that breaks along its length: whole until then, in two free parts after it."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, run_text, scene_of
from modal_runs import modes_at

GRAVITY, LENGTH, MASS, EI = 9.81, 2.0, 0.5, 100.0
LET_GO = '[events.tip]\nbreaks = "rod.end"\ntime = "5 ms"\n'


def cantilever(*cuts, events="", end='"free"', time=0.004, more="", courant=0.5):
    """A rod out of a wall that is to break at `cuts` (m) from 30 ms on."""
    for k, place in enumerate(cuts):
        events += f'[events.cut{k}]\nbreaks = "rod@{place} m"\ntime = {time}\nstart = 0.0301\n'
    return f"""
gravity = {GRAVITY}
[materials.steel]
law = "linear"
EA = 1e5
[lines.rod]
material = "steel"
length = {LENGTH}
segments = 20
mass = {MASS}
bending = {{ EI = {EI} }}
start = {{ fixed = [0, 0, 0], direction = [1, 0, 0] }}
end = {end}
{more}
{events}
[solver]
waves = "plain"
courant = {courant}
[output]
duration = 0.05
every = 0.0025
quantities = ["position", "velocity", "energy"]
"""


def sagging(*cuts, **changes):
    """The same bent by a force at its end, which is let go at once."""
    force = "{ held = { pretension = 3, direction = [0, 0, -1] } }"
    return cantilever(*cuts, events=LET_GO, end=force, **changes)


def together(parts):
    """Nodes (..., d, n) of the parts of a line as those of one."""
    return np.concatenate([parts[0], *(part[..., 1:] for part in parts[1:])], axis=-1)


def nodes_at_rest(folder, text):
    rest, _ = equilibrium_of(scene_of(folder, text))
    assert bool(rest.converged)
    return together([np.asarray(line.reference) for line in rest.model.lines.values()])


# with parts of one segment, at either end and between two cuts
CUTS = [((1.0,), ""), ((0.8,), "grading = 4"), ((0.1, 0.2, 1.9), ""), ((0.1,), ""),
        ((0.5, 0.6, 1.5), "")]  # fmt: skip


@pytest.mark.parametrize(
    ("cuts", "more"),
    [CUTS[2], *(pytest.param(*CUTS[k], marks=pytest.mark.slow) for k in (0, 1, 3, 4))],
)
def test_a_cantilever_that_is_to_break_rests_as_one_that_is_not(tmp_path, cuts, more):
    whole = nodes_at_rest(tmp_path, cantilever(more=more))
    cut = nodes_at_rest(tmp_path, cantilever(*cuts, more=more))
    np.testing.assert_allclose(cut, whole, atol=1e-12)
    # w L^4 / (8 EI), less a thousandth since it turns by 4 degrees
    assert -cut[1, -1] == pytest.approx(GRAVITY * MASS * LENGTH**4 / (8.0 * EI), rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize(("cuts", "more"), CUTS[1::3])
def test_until_it_breaks_it_moves_as_one_that_does_not(tmp_path, cuts, more):
    whole = run_text(tmp_path, sagging(more=more))
    cut = run_text(tmp_path, sagging(*cuts, more=more))
    assert cut.statuses == whole.statuses == ["OK"]
    parts = [cut[f"rod-{k + 1}.position"][0].swapaxes(1, 2) for k in range(len(cuts) + 1)]
    apart = np.abs(together(parts) - whole["position"][0].swapaxes(1, 2)).max(axis=(1, 2))
    held = cut.time <= 0.03
    assert np.abs(whole["position"][0, held] - whole["position"][0, 0]).max() > 1e-3
    assert np.all(apart[held] < 1e-12)
    assert np.all(apart[~held] > 1e-4)
    np.testing.assert_allclose(
        cut.energy["bending"][0, held], whole.energy["bending"][0, held], rtol=1e-10
    )


@pytest.mark.parametrize("time", [0.004, pytest.param(0, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_the_account_closes_over_the_break(tmp_path, time):
    closures = []
    for courant in (0.5, 0.25):
        ran = run_text(tmp_path, sagging(1.0, time=time, courant=courant))
        assert ran.statuses == ["OK"]
        closures.append(ran.outcomes[0].energy_closure)
    assert closures[0] < 1e-3
    assert closures[1] == pytest.approx(closures[0] / 4.0, rel=0.2)  # of second order in the step


@pytest.mark.slow
def test_after_the_break_its_parts_are_free(tmp_path):
    ran = run_text(tmp_path, sagging(1.0))
    free = ran.time > 0.0342
    place, speed = (ran[f"rod-2.{key}"][0, free] for key in ("position", "velocity"))
    mass = np.full(place.shape[1], 0.1 * MASS)
    mass[[0, -1]] *= 0.5
    weigh = np.einsum("n,tnd->td", mass, speed)
    fall = weigh / mass.sum() + np.outer(ran.time[free], [0.0, 0.0, GRAVITY])
    np.testing.assert_allclose(fall, np.broadcast_to(fall[0], fall.shape), atol=1e-9)
    middle = np.einsum("n,tnd->td", mass, place)[:, None] / mass.sum()
    turning = np.einsum("n,tnd->td", mass, np.cross(place - middle, speed))[:, 1]
    assert abs(turning[0]) > 1e-3
    np.testing.assert_allclose(turning, turning[0], rtol=1e-9)


def test_the_modes_are_those_of_the_whole(tmp_path):
    # about an arc, at which the parts meet aslant
    angle = np.linspace(0.0, 0.2, 21)
    arc = LENGTH / 0.2 * np.stack([np.sin(angle), 0.0 * angle, np.cos(angle) - 1.0], axis=1)
    whole = modes_at(tmp_path, cantilever(), {"rod": arc})
    cut = modes_at(tmp_path, cantilever(0.6), {"rod-1": arc[:7], "rod-2": arc[6:]})
    np.testing.assert_allclose(cut.frequency[:4], whole.frequency[:4], rtol=1e-6)
