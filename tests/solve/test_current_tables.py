"""A line across a current that is given at heights, against the equations of a string it drags at."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import root

RHO, D, CN, EA, LENGTH, PULL = 1025.0, 0.05, 1.2, 2e5, 60.0, 2e3
Z = np.array([-60.0, -40.0, -15.0, 0.0])
TURNING = np.array([[0.1, -0.3, 0.0], [0.2, 0.5, 0.0], [0.9, 0.4, 0.0], [1.4, 0.0, 0.0]])
SCENE = f"""
[water]
density = {RHO}
[water.current]
profile = "table"
z = {Z.tolist()}
velocity = {{velocity}}
[materials.rope]
law = "linear"
EA = {EA}
[lines.rope]
material = "rope"
length = {LENGTH}
segments = {{segments}}
mass = 2
diameter = {D}
drag = {{{{ normal = {CN}, tangential = 0 }}}}
start = {{{{ fixed = [0, 0, -60] }}}}
end = {{{{ fixed = [0, 0, {LENGTH * PULL / EA}] }}}}
[output]
duration = 1
every = 0.1
"""


def string(velocity):
    """Shape (m) over z of a string of constant material, pulled straight from end to end.

    The tension vector P obeys dP/ds = -q, q = rho d C u_n |u_n| / 2 per unstretched metre, with u_n
    the velocity across r' / |r'| and r' = P / |P| (1 + |P| / EA) along the unstretched s.
    """

    def flow(z):
        return np.stack([np.interp(z, Z, velocity[:, k]) for k in range(3)])

    def slopes(s, y):
        pull = np.linalg.norm(y[3:], axis=0)
        along = y[3:] / pull
        u = flow(y[2])
        across = u - along * np.sum(u * along, axis=0)
        q = 0.5 * RHO * D * CN * np.linalg.norm(across, axis=0) * across
        return np.concatenate([along * (1.0 + pull / EA), -q])

    def shape(pull):
        start = np.concatenate([[0.0, 0.0, -60.0], pull])
        return solve_ivp(
            slopes, (0.0, LENGTH), start, rtol=1e-10, atol=1e-10, dense_output=True
        ).sol

    end = np.array([0.0, 0.0, LENGTH * PULL / EA])
    found = root(lambda pull: shape(pull)(LENGTH)[:3] - end, [1e3, 1e3, 1.5 * PULL], tol=1e-9)
    assert found.success
    return shape(found.x)


def shape_of(tmp_path, velocity, segments):
    scene = scene_of(tmp_path, SCENE.format(velocity=velocity.tolist(), segments=segments))
    return nodes_in_space(*equilibrium_of(scene)).T


@pytest.mark.parametrize("turning", [pytest.param(False, marks=pytest.mark.slow), True])
@pytest.mark.slow
def test_a_string_hangs_in_it_as_its_equations_have_it(tmp_path, turning):
    velocity = TURNING if turning else TURNING * [1.0, 0.0, 0.0]
    sol = string(velocity)
    errors = []
    for segments in (60, 120):
        nodes = shape_of(tmp_path, velocity, segments)
        exact = sol(np.linspace(0.0, LENGTH, segments + 1))[:3].T
        errors.append(np.abs(nodes - exact).max())
    assert np.ptp(exact[:, 0]) > 2.0  # the current carries it metres aside
    assert np.ptp(exact[:, 1]) > 0.5 or not turning
    # lumps on a curve with kinks: near enough the second order
    assert errors[1] < 2e-4
    assert errors[1] < errors[0] / 3.0
