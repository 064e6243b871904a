"""The end of a slack line coasts: nothing but drag acts on it."""

import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import NYLON, equilibrium_of, scene_of

from lumpedcable.model.motion import acceleration, kick

SCENE = f"""
[water]
density = "1000 kg/m3"
{NYLON.replace("false", "true")}
[lines.rope]
material = "nylon"
length = "60 m"
segments = 30
mass = "2 kg/m"
diameter = "50 mm"
drag = {{ normal = 1.5, tangential = 0.02, convention = "projected" }}
start = {{ fixed = [0, 0, 0] }}
end = {{ held = {{ pretension = "90 kN", direction = [1, 0, 0] }} }}
[events.break]
breaks = "rope.end"
time = 0
[output]
duration = "40 ms"
every = "2 ms"
"""


@pytest.mark.parametrize("dt", [None, 2e-4])
@pytest.mark.slow
def test_drag_slows_the_end_of_a_slack_line_by_its_own_speed(tmp_path, dt):
    found, _ = equilibrium_of(scene_of(tmp_path, SCENE))
    model, line = found.model, found.model.lines["rope"]
    # straight, 1 % shorter than unstretched, and shortening evenly: no tension, no viscosity
    x = np.linspace(0.0, 60.0, 31)
    place = {"rope": jnp.asarray(0.99 * x - np.asarray(line.reference)[0])[None]}
    before = -0.8 * x
    speed = {"rope": jnp.asarray(before)[None]}
    t = jnp.asarray(0.1)
    # 1000 kg/m3 x 50 mm x 0.02 / 2 on 2 kg/m
    per_metre = 0.5 * 1000.0 * 0.05 * 0.02 / 2.0
    if dt is None:
        gain = acceleration(model, t, place, speed, {})[0]["rope"][0]
        wanted = per_metre * before**2
    else:
        _, after, _, _ = kick(model, t, place, speed, {}, jnp.asarray(dt))
        gain = (after["rope"][0] - before) / dt
        wanted = per_metre * (before + 0.5 * dt * np.asarray(gain)) ** 2
    np.testing.assert_allclose(gain[1:], wanted[1:], rtol=1e-9)
