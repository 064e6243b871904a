"""Friction of a trolley on a line that a winch hauls past it, from whichever end it hauls."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, run_text, scene_of
from scipy.interpolate import BSpline

from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import winch_name
from lumpedcable.model.forces import evaluate
from lumpedcable.physics.coupling import slowed

SPAN, SEGMENTS, MU, FADE, SET = 10.0, 20, 0.1, 0.05, 30e3
SIDES = ("end", "start")


def scene_with(winch, place=4.0, speed=0.2):
    """A trolley held along a line between a winch and a post that draws away from it at `speed` (m/s).

    `place` (m) counts from the post, so that the scenes of both sides are each other's mirror images.
    """
    far, near = (0.0, SPAN) if winch == "end" else (SPAN, 0.0)
    held = f'{{ winch = {{ at = [{near}, 0, 0], tension = "30 kN", inertia = 20 }} }}'
    ends = {winch: held, "start" if winch == "end" else "end": '"ship.post"'}
    away = -1.0 if winch == "end" else 1.0
    return f"""
gravity = 9.81
[materials.wire]
law = "linear"
EA = "20 MN"
damping = "20 kN s"
[bodies.ship]
position = [{far}, 0, 0]
motion.surge = {{ amplitude = {away * speed * 100.0}, period = {200 * np.pi} }}
motion.ramp = "0.4 s"
points = {{ post = [0, 0, 0] }}
[bodies.cargo]
mass = "1 t"
[bodies.cargo.on]
line = "line"
place = {abs(far - place)}
speed = 1e-9
stop = 0.4
friction = {{ coefficient = {MU}, speed = {FADE} }}
[lines.line]
material = "wire"
length = {SPAN}
segments = {SEGMENTS}
mass = 3
start = {ends["start"]}
end = {ends["end"]}
[output]
duration = "1.2 s"
every = "5 ms"
quantities = ["tension", "energy"]
"""


def spline(nodes, s):
    """The cubic B-spline of nodes (d, n + 1), one mirrored beyond either end, at s segments: scipy's."""
    more = np.column_stack([2 * nodes[:, 0] - nodes[:, 1], nodes, 2 * nodes[:, -1] - nodes[:, -2]])
    knots = np.arange(more.shape[1] + 4) - 3.0
    return BSpline(knots, more.T, 3)(s)


class Moving:
    """A scene at its equilibrium, everything in some motion: velocities by line and body."""

    def __init__(self, folder, winch):
        rest, _ = equilibrium_of(scene_of(folder, scene_with(winch).replace('"30 kN"', str(SET))))
        assert bool(rest.converged)
        self.model, self.side = rest.model, winch
        draw = np.random.default_rng(7)
        self.velocity = {"line": 0.05 * draw.normal(size=self.model.lines["line"].reference.shape)}
        for name, body in self.model.bodies.items():
            self.velocity[body_key(name)] = 0.05 * draw.normal(size=body.reference.shape)
        self.payout = body_key(winch_name("line"))
        self.velocity[self.payout] = np.array([0.08])

    def found(self, model=None):
        """What the trolley does, and the pull at the winch (N)."""
        model = self.model if model is None else model
        zero = jax.tree.map(jnp.zeros_like, self.velocity)
        moved = jax.tree.map(jnp.asarray, self.velocity)
        return _evaluated(model, zero, moved)

    def slip(self, foot):
        """Velocity (m/s) of the trolley less that of the piece of line that is at the foot now.

        That piece keeps its unstretched distance from the end that no winch holds.
        """
        nodes = np.asarray(self.model.lines["line"].reference)
        length = float(self.model.bodies[winch_name("line")].reference[0])
        paid = 0.0 if self.side == "end" else float(SEGMENTS)
        distance = (foot - paid) * length / SEGMENTS

        def place(t):
            now = length + t * self.velocity[self.payout][0]
            return spline(nodes + t * self.velocity["line"], paid + distance * SEGMENTS / now)

        h = 1e-5
        return self.velocity[body_key("cargo")][:2] - (place(h) - place(-h)) / (2.0 * h)


@eqx.filter_jit
def _evaluated(model, displacement, velocity):
    found = evaluate(model, jnp.zeros(()), displacement, velocity, {})
    return found.pulls[0], found.drawn[winch_name("line")]


@pytest.mark.slow
@pytest.mark.parametrize("winch", ["end", "start"])
def test_friction_opposes_the_slip_on_the_substance_and_its_work_is_whole(tmp_path, winch):
    moving = Moving(tmp_path, winch)
    pull, drawn = moving.found()
    friction = pull.taken["friction"]
    nodes = np.asarray(moving.model.lines["line"].reference)
    place = np.asarray(moving.model.bodies["cargo"].reference)
    near = np.linspace(0.0, SEGMENTS, 200_001)
    foot = near[np.argmin(np.sum((spline(nodes, near) - place) ** 2, axis=1))]
    way = spline(nodes, foot + 1e-4) - spline(nodes, foot - 1e-4)
    way /= np.sqrt(way @ way)
    slip = moving.slip(foot) @ way
    # the push across carries the weight, where the trolley is at rest on the line
    weight = 9810.0
    expected = -MU * weight * np.tanh(slip / FADE)
    assert float(friction.body @ way) == pytest.approx(expected, rel=2e-3)
    # virtual work: what it does on trolley, nodes and payout is the force times the slip
    work = float(friction.body @ moving.velocity[body_key("cargo")][:2])
    work += float(np.sum(np.asarray(friction.line) * moving.velocity["line"]))
    smooth = eqx.tree_at(lambda m: m.couplings[0].law.friction, moving.model, jnp.zeros(()))
    work += float(drawn - moving.found(smooth)[1]) * moving.velocity[moving.payout][0]
    assert work == pytest.approx(float(friction.body @ way) * slip, rel=2e-3)
    assert work < 0.0


@pytest.mark.parametrize("fade", [1e-3, 0.01, 3.0])
@pytest.mark.parametrize("held", [0.0, 1e-6, 0.02, 0.3, 5.0])
def test_a_slip_that_friction_slows_is_the_root_of_its_equation(fade, held):
    for free in (-2.0, -0.3, -1e-5, 0.0, 0.019, 0.31, 20.0):
        v = float(slowed(jnp.asarray(free), jnp.asarray(held), jnp.asarray(fade)))
        # what it is slowed by lies between 0 and all of it
        assert 0.0 <= v * np.sign(free) <= abs(free)
        assert v + held * np.tanh(v / fade) == pytest.approx(free, rel=1e-9, abs=1e-15)


# on the light line friction could change the nodes' velocity by ten times their slip in one step
LIGHT = ("lines.line.mass=0.1", "wire.damping=500", "friction.speed=0.002")


@pytest.mark.slow
@pytest.mark.parametrize(("sets", "mass", "speed"), [((), 3.0, 0.2), (LIGHT, 0.1, 0.02)])
@pytest.mark.parametrize("winch", SIDES)
def test_the_winch_keeps_its_tension_and_friction_adds_to_it_beyond_the_trolley(
    tmp_path, winch, sets, mass, speed
):
    ran = run_text(tmp_path, scene_with(winch, SPAN / 2, speed), *sets)
    assert ran.statuses == ["OK"]
    tension = ran["tension"][0] if winch == "end" else ran["tension"][0][:, ::-1]
    late = ran.time > 0.7
    # the post hauls the line past the trolley, which hangs in the middle: T1 - T2 = mu N / cos a with
    # (T1 + T2) sin a = N, where a is half the angle by which the line bends under the trolley: that of
    # the straight ways to the posts, less what the line's own weight makes of it
    cargo = ran.bodies["cargo"]["position"][0, late]
    out = speed * (ran.time[late] - 0.2)  # a ramp of 0.4 s
    ways = [-cargo[:, 2] / (SPAN / 2 + out), -cargo[:, 2] / (SPAN / 2)]
    bend = np.mean(ways) - mass * 9.81 * SPAN / 2 / (2 * SET)
    rub = SET * 2 * MU * bend / (1 - MU * bend)
    # 3 %: the weight of the line between the places where it is read is 1.2 % of the friction
    near, far = tension[late][:, -3].mean(), tension[late][:, 2].mean()
    assert near == pytest.approx(SET, abs=0.03 * rub)
    assert far - near == pytest.approx(rub, rel=0.03)
    # friction takes its force times the line that has come past, and never gives anything back
    lost, beyond = ran.energy["lost_friction"][0], np.hypot(SPAN / 2 + out, cargo[:, 2])
    assert np.ptp(lost[late]) == pytest.approx(rub * np.ptp(beyond), rel=0.03)
    assert np.min(np.diff(lost)) >= 0.0
    # nothing is left open but what the step owes
    assert ran.outcomes[0].energy_closure < 1e-6
