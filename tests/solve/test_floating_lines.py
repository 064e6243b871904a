"""Lines that float: slack ones in a current, and derivatives of what floats or is lifted off a bed."""

import jax
import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, run_text, scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import root

from lumpedcable import response

G, RHO, D, CN, EA, MASS = 9.81, 1000.0, 0.25, 1.2, 1e7, 20.0
HOSE = f"""
gravity = {G}
[water]
density = {RHO}
surface = 0
current = {{{{ velocity = [0, 1, 0] }}}}
[materials.own]
law = "linear"
EA = {EA}
[lines.hose]
material = "own"
length = {{length}}
segments = 44
mass = {MASS}
diameter = {D}
drag = {{{{ normal = {CN}, tangential = 0 }}}}
start = {{{{ fixed = [0, 0, 0] }}}}
end = {{{{ fixed = [100, 0, 0] }}}}
[output]
"""


def bow(length):
    """Tension (N) at the end and greatest bow (m) of a string that lies in the surface.

    Wet to the share s = m / (rho A), where it floats; P' = -s rho d C u_n |u_n| / 2 per metre.
    """
    share = MASS / (RHO * np.pi * D**2 / 4.0)

    def slopes(_, y):
        pull = np.hypot(y[2], y[3])
        along = y[2:] / pull
        across = np.array([0.0, 1.0]) - along * along[1]
        load = 0.5 * RHO * D * CN * share * np.linalg.norm(across) * across
        return [*(along * (1.0 + pull / EA)), *-load]

    def shape(pull):
        return solve_ivp(
            slopes, (0.0, length), [0.0, 0.0, *pull], rtol=1e-9, atol=1e-9, dense_output=True
        ).sol

    found = root(lambda pull: shape(pull)(length)[:2] - [100.0, 0.0], [3e3, 3e3], tol=1e-8)
    assert found.success
    sol = shape(found.x)
    return np.hypot(*found.x), np.max(sol(np.linspace(0.0, length, 201))[1])


@pytest.mark.parametrize("length", [110, pytest.param(120, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_a_slack_hose_on_the_water_bows_with_the_current(tmp_path, length):
    # it has more length than way on the surface, on which nothing pushes it together
    found, coordinates = equilibrium_of(scene_of(tmp_path, HOSE.format(length=length)))
    assert found.converged
    nodes = nodes_in_space(found, coordinates, "hose").T
    tension, side = bow(length)
    assert nodes[:, 1].max() == pytest.approx(side, rel=2e-3)
    step = np.linalg.norm(np.diff(nodes, axis=0), axis=1) / (length / 44)
    assert EA * (step[0] - 1.0) == pytest.approx(tension, rel=5e-3)


BUOYANT = f"""
gravity = {G}
[water]
density = 1025
SURFACE
[seabed]
height = -40
stiffness = 1e5
[materials.own]
law = "linear"
EA = 2e6
tension_only = true
[lines.hose]
material = "own"
length = 90
segments = 12
mass = 15
diameter = 0.16
start = {{ fixed = [0, 0, -40] }}
end = {{ fixed = [75, 0, -3] }}
[output]
"""


@pytest.mark.parametrize("surface", ["surface = 0", ""], ids=["floats", "deep"])
@pytest.mark.slow
def test_what_is_lifted_off_a_bed_has_the_same_derivatives_both_ways(tmp_path, surface):
    path = tmp_path / "scene.toml"
    path.write_text(BUOYANT.replace("SURFACE", surface), encoding="utf-8")
    keys = ["lines.hose.diameter", "lines.hose.end.fixed.0"]
    of = response(path, keys, "first tension at hose.end")
    ahead, back = (np.asarray(d(of)(of.values)) for d in (jax.jacfwd, jax.grad))
    np.testing.assert_allclose(back, ahead, rtol=1e-8)
    assert np.all(ahead != 0.0)


LOG = """
gravity = 9.81
[water]
density = 1000
surface = 0
[materials.own]
law = "linear"
EA = 1e6
[lines.aside]
material = "own"
length = 1
segments = 1
mass = 20
diameter = 0.02
start = { fixed = [0, 0, 50] }
end = "free"
[bodies.log]
mass = 2600
volume = 10
size = [10, 1, 1]
position = [0, 0, 0.2]
attitude = ["39 deg", 0, 0]
free = ["z", "roll"]
control = { damping = [0, 0, "9 kN s/m"], turn_damping = ["2 kN m s/rad", 0, 0] }
[output]
duration = "25 s"
every = "1 s"
"""


@pytest.mark.slow
def test_a_log_settles_where_its_polygon_has_no_arm(tmp_path):
    # relative density 0.26: a square section rests at 29.8 degrees (naval architecture by hand: the
    # wetted polygon's middle is under its own middle)
    ran = run_text(tmp_path, LOG)
    assert ran.statuses == ["OK"]
    roll = np.degrees(ran.bodies["log"]["attitude"][0, -1, 0])
    assert roll == pytest.approx(29.8, abs=0.2)
