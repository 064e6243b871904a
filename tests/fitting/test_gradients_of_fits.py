"""Derivatives of records by every kind of number, against central differences of several steps.

A central difference is wrong by h^2 / 6 of the third derivative and by rounding over h; somewhere
between it is right to better than 1e-6 where the model is smooth. Breaks, shocks, slack and contact are
crossed here; at the instant of a kink itself the derivative is one-sided. The limiter of corrected waves
has kinks everywhere, so that a long step crosses some; and a break's time moves the end of its ramp,
where the force's second derivative jumps: there the difference comes in with the first power of h.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import study_of
from gradient_scenes import DRAGGED, FERRY, RODS, TROLLEY

from lumpedcable.fitting.residual import run_group
from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import setting_of
from lumpedcable.status import Status
from lumpedcable.study.compiled import RUN_ONCE

STEPS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # of the number itself

BREAK = """
gravity = 9.81
[water]
density = 1025
[materials.nylon]
law = "tanh"
p1 = "270.3 kN"
p2 = 10.2
p3 = -2.128
p4 = "262.7 kN"
p5 = "5 kN"
damping = "200 N s"
[lines.rope]
material = "nylon"
length = "60 m"
segments = 12
mass = "2.238 kg/m"
diameter = "50 mm"
drag = { normal = 1.5, tangential = 0.01 }
added_mass = { normal = 1.0, tangential = 0.1 }
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "450 kN", direction = [1, 0, 0] } }
[events.break]
breaks = "rope.end"
time = "5 ms"
start = "1 ms"
[solver]
waves = "plain"
[output]
duration = "70 ms"
every = "2 ms"
"""
# a slack line pulled taut by a shaken end, over a bed that it lies on and lifts from
CONTACT = """
gravity = 9.81
[seabed]
height = -8
stiffness = "20 kPa"
damping = "500 Pa s"
[materials.chain]
law = "linear"
EA = "200 kN"
tension_only = true
[lines.chain]
material = "chain"
length = "40 m"
segments = 10
mass = "20 kg/m"
start = { fixed = [0, 0, -8] }
end = { motion = { position = [34, 0, 0], amplitude = [2, 0, 1], period = "3 s", phase = 0.3 } }
[solver]
waves = "plain"
[output]
duration = "2 s"
every = "50 ms"
"""
# a body at a joint in a current, a bending line below it that breaks; statics without a closed form
NET = """
gravity = 9.81
[water]
density = 1025
current = { velocity = ["0.8 m/s", "0.2 m/s", 0] }
[materials.wire]
law = "linear"
EA = "50 kN"
[materials.fibre]
law = "polynomial"
coefficients = ["20 kN", "30 kN"]
damping = "20 N s"
[lines.upper]
material = "wire"
length = "12 m"
segments = 4
mass = "1.5 kg/m"
diameter = "30 mm"
drag = { normal = 1.2, tangential = 0.05 }
added_mass = { normal = 1.0 }
start = { motion = { position = [0, 0, 10], amplitude = [0.3, 0, 0.2], period = "1.7 s" } }
end = "bob"
[lines.lower]
material = "fibre"
length = "11 m"
segments = 4
mass = "1 kg/m"
diameter = "40 mm"
bending = { EI = "300 N m2" }
drag = { normal = 1.0, tangential = 0.02 }
start = "bob"
end = { held = { pretension = "500 N", direction = [0.6, 0, -0.8] } }
[bodies.bob]
mass = "40 kg"
position = [4, 0, 0]
volume = "0.005 m3"
[events.slip]
breaks = "lower.end"
time = "0.1 s"
start = "0.2 s"
[solver]
waves = "plain"
[output]
duration = "1 s"
every = "50 ms"
"""
# a box that floats and swings on a spring, thrown
BODY = """
gravity = 9.81
[water]
density = 1025
[materials.spring]
law = "linear"
EA = "2 kN"
[lines.spring]
material = "spring"
length = "3 m"
segments = 2
mass = "0.5 kg/m"
diameter = "5 mm"
start = { fixed = [0, 0, 3] }
end = "box.top"
[bodies.box]
mass = "60 kg"
size = [0.6, 0.5, 0.4]
position = [0.5, 0, 0]
velocity = [0.8, 0, -0.5]
attitude = [0, 0.2, 0]
points = { top = [0.1, 0, 0.2] }
hull = { above_water = 0.1 }
[solver]
waves = "plain"
[output]
duration = "0.6 s"
every = "50 ms"
"""
# keys, and what is looked at; the history is that of the place
CASES = {
    "break, shock": (BREAK, "max tension at rope.start", [
        "materials.nylon.p1", "materials.nylon.p2", "materials.nylon.p3", "materials.nylon.p4",
        "materials.nylon.p5", "materials.nylon.damping", "lines.rope.length", "lines.rope.mass",
        "lines.rope.diameter", "lines.rope.drag.tangential", "lines.rope.added_mass.tangential",
        "lines.rope.end.held.pretension", "events.break.time", "events.break.start",
        "water.density"]),
    "joint, bending, current": (NET, "max tension at upper.start", [
        "materials.wire.EA", "materials.fibre.coefficients.0", "materials.fibre.damping",
        "lines.upper.length", "lines.lower.mass", "lines.lower.diameter", "lines.lower.drag.normal",
        "lines.upper.added_mass.normal", "lines.lower.bending.EI", "lines.lower.end.held.pretension",
        "bodies.bob.mass", "bodies.bob.volume", "water.current.velocity.0", "water.density",
        "lines.upper.start.motion.amplitude.0", "events.slip.start"]),
    "body, hull": (BODY, "max tension at spring.start", [
        "materials.spring.EA", "lines.spring.length", "lines.spring.mass", "bodies.box.mass",
        "bodies.box.size.0", "bodies.box.position.0", "bodies.box.velocity.2", "bodies.box.attitude.1",
        "bodies.box.points.top.0", "bodies.box.hull.above_water", "water.density", "gravity"]),
    "limiter": (BREAK.replace("plain", "corrected"), "max tension at rope.start", [
        "materials.nylon.p1", "materials.nylon.p5", "lines.rope.mass", "lines.rope.length",
        "lines.rope.drag.tangential", "lines.rope.end.held.pretension", "events.break.time"]),
    "slack, contact": (CONTACT, "max tension at chain.end", [
        "materials.chain.EA", "lines.chain.mass", "lines.chain.length", "seabed.stiffness",
        "seabed.damping", "seabed.height", "lines.chain.end.motion.amplitude.0",
        "lines.chain.end.motion.period", "lines.chain.end.motion.phase",
        "lines.chain.end.motion.position.2", "gravity"]),
    "trolley, winch": (TROLLEY, "max velocity at highline@1.5m", [
        "bodies.cargo.mass", "bodies.cargo.on.place", "bodies.cargo.on.speed",
        "bodies.cargo.on.friction.coefficient", "bodies.cargo.on.contact.stiffness",
        "bodies.cargo.on.contact.damping", "bodies.cargo.height", "materials.steel.EA",
        "materials.steel.damping", "lines.highline.mass", "lines.highline.end.winch.tension",
        "lines.highline.end.winch.inertia", "lines.highline.end.winch.damping",
        "bodies.ship.motion.surge.amplitude", "gravity"]),
    "ideal cable, sheave, ship": (FERRY, "min h", [
        "bodies.cargo.mass", "bodies.cargo.on.place", "bodies.cargo.on.speed",
        "lines.highline.end.winch.tension", "bodies.ship.mass", "bodies.ship.size.0",
        "bodies.ship.points.post.2", "bodies.ship.hull.above_keel",
        "bodies.ship.control.stiffness.0", "bodies.ship.control.damping.2", "water.density",
        "gravity"]),
    "friction of the bed": (DRAGGED, "max tension at wire.start", [
        "seabed.friction", "lines.wire.mass", "lines.wire.length", "materials.wire.EA"]),
    "rods, sliding block": (RODS, "max tension at block.ring", [
        "bodies.block.mass", "bodies.block.velocity.0", "bodies.block.friction",
        "lines.upper.mass", "lines.lower.mass", "lines.lower.length", "gravity"]),
}  # fmt: skip


def histories(folder, text, what, keys):
    """f(values) of a run: its history at the place; the values of the scene."""
    scene = study_of(folder, text).runs[0]
    spec, arrays = setting_of(scene, read_scalar(what, scene), keys, False)
    values = np.array([scene.numbers()[key] for key in keys])

    def f(x):
        found, status, _, _ = run_group(spec, arrays, x)
        return found[0, 0], status[0]

    return f, values


@pytest.mark.parametrize(
    "case",
    [
        "break, shock",
        *(pytest.param(c, marks=pytest.mark.slow) for c in CASES if c != "break, shock"),
    ],
)
@pytest.mark.slow
def test_derivatives_are_those_of_differences(tmp_path, case):
    text, what, keys = CASES[case]
    f, values = histories(tmp_path, text, what, keys)
    plain = jax.jit(f, compiler_options=RUN_ONCE)
    jacobian = jax.jit(jax.jacfwd(lambda x: f(x)[0]), compiler_options=RUN_ONCE)
    slope = np.asarray(jacobian(jnp.asarray(values)))[1:]
    history, status = plain(values)
    assert Status(int(status)) is Status.OK
    assert np.ptp(history) > 0.3 * np.max(history)
    for k, key in enumerate(keys):
        scale = np.max(np.abs(slope[:, k]))
        assert scale > 0.0, key
        worst = []
        for h in STEPS:
            step = np.zeros(values.size)
            step[k] = h * (abs(values[k]) or 1.0)
            up, down = (np.asarray(plain(values + s * step)[0]) for s in (1, -1))
            difference = (up - down)[1:] / (2.0 * step[k])
            worst.append(np.max(np.abs(difference - slope[:, k])) / scale)
        assert min(worst) < 1e-6, (key, worst)
