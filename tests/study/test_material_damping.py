"""A broken line of a damped material, at steps as large as the bound lets them be."""

import numpy as np
import pytest
from engine_runs import run_text
from scipy.integrate import solve_ivp

LINE = """
[materials.damped]
law = "linear"
EA = "1 MN"
tension_only = false
damping = "1 kN s"

[lines.rope]
material = "damped"
length = "50 m"
segments = 50
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ held = {{ pretension = "50 kN", direction = [1, 0, 0] }} }}

[events.break]
breaks = "rope.end"
time = "2 ms"

[solver]
waves = "{waves}"

[sweep]
"materials.damped.damping" = ["0.2 kN s", "0.5 kN s", "1 kN s", "2 kN s"]

[output]
duration = "200 ms"
every = "20 ms"
quantities = ["velocity", "energy"]
"""


@pytest.mark.parametrize("waves", ["corrected", pytest.param("viscous", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_damping_and_viscosity_together_are_stable(tmp_path, waves):
    # the end goes at T / sqrt(EA m) once the break and k / EA, at most 2 ms, are long past
    ran = run_text(tmp_path, LINE.format(waves=waves))
    assert ran.statuses == ["OK"] * 4
    assert max(outcome.energy_closure for outcome in ran.outcomes) < 1e-3
    assert np.abs(ran["velocity"][:, 2, -1, 0]) == pytest.approx(50.0, rel=2e-3)
    # 200 ms are four ways to the wall and back, and damping takes energy all along
    assert np.max(np.abs(ran["velocity"])) < 60.0


SLACK = """
[materials.rope]
law = "linear"
EA = "1 MN"
tension_only = true
damping = "100 kN s"

[lines.rope]
material = "rope"
length = "10 m"
segments = {segments}
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = ["9 m", 0, 0], velocity = ["0.4 m/s", 0, 0], ramp = "0.1 s" }} }}

[output]
duration = "2 s"
every = "0.1 s"
"""


@pytest.mark.parametrize("segments", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_what_is_slack_does_not_pull_while_it_is_drawn_out(tmp_path, segments):
    ran = run_text(tmp_path, SLACK.format(segments=segments))
    assert ran.statuses == ["OK"]
    assert np.max(np.linalg.norm(np.diff(ran["position"][0], axis=1), axis=-1)) < 10 / segments
    assert not np.any(ran["tension"])


BOUNCE = """
gravity = 9.81

[materials.cord]
law = "linear"
EA = "{EA} N"
tension_only = true
damping = "{c} N s"

[bodies.load]
mass = {M}
position = [0, 0, {z}]
velocity = [0, 0, {v}]
free = ["z"]

[lines.cord]
material = "cord"
length = {L}
segments = 1
mass = {m}
start = {{ fixed = [0, 0, 0] }}
end = "load"

[solver]
waves = "plain"
courant = {courant}

[output]
duration = 6
every = "10 ms"
"""


def bounce(EA, c, M, m, L, v):
    """Height (m) and tension (N) every 10 ms of a load on a cord that catches it and is slack between.

    One equation, M' z" = T - M' g, T = max(EA e + c de/dt, 0) where e > 0, and 0 elsewhere.
    """
    whole = M + 0.5 * m * L
    start = -L * (1.0 + whole * 9.81 / EA)

    def tension(y):
        e, rate = -y[0] / L - 1.0, -y[1] / L
        return np.where(e > 0.0, np.maximum(EA * e + c * rate, 0.0), 0.0)

    t = np.linspace(0.0, 6.0, 601)
    found = solve_ivp(
        lambda _, y: [y[1], tension(y) / whole - 9.81], (0.0, 6.0), [start, v],
        t_eval=t, max_step=1e-4, rtol=1e-9, atol=1e-9,
    )  # fmt: skip
    return start, found.y[0], tension(found.y)


@pytest.mark.slow
def test_a_load_that_bounces_on_a_damped_cord(tmp_path):
    numbers = {"EA": 5e4, "c": 2e3, "M": 100.0, "m": 0.5, "L": 10.0, "v": 12.0}
    z, height, tension = bounce(**numbers)
    text = BOUNCE.format(z=z, courant=0.02, **numbers)
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    free = height > -10.0
    assert 0.3 < np.mean(free) < 0.8  # it flies, several times
    assert np.sum(np.diff(free.astype(int)) == 1) >= 3
    assert ran.bodies["load"]["position"][0, :, 2] == pytest.approx(height, abs=2e-3)
    assert np.max(ran["tension"]) == pytest.approx(np.max(tension), rel=2e-3)
    assert not np.any(ran["tension"][0, :, 0][height > -9.99])
