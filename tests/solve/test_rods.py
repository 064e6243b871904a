"""Inextensible lines: pendulums of rigid rods against their equations; bodies that stick and slide."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import order_of, run_text, scene_of, sliding_block
from scipy.integrate import solve_ivp

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.scene import SceneError
from lumpedcable.solve.constrained import Constrained
from lumpedcable.solve.integrate import initial_state
from lumpedcable.solve.leapfrog import CableTerm
from lumpedcable.solve.start import start_of

G = 9.81
L1, L2, M1, M2 = 1.0, 0.7, 2.0, 1.5  # m, kg per m
ANGLE = 1.2  # rad, of the first rod at the start
PENDULUM = f"""
gravity = {G}
[materials.stiff]
law = "inextensible"
[lines.upper]
material = "stiff"
length = {L1}
segments = 1
mass = {M1}
start = {{ fixed = [0, 0, 0] }}
end = {{ joined = "lower.start", at = [{L1 * np.sin(ANGLE)}, 0, {-L1 * np.cos(ANGLE)}] }}
[lines.lower]
material = "stiff"
length = {L2}
segments = 1
mass = {M2}
start = "upper.end"
end = "free"
[output]
duration = "1.5 s"
every = "50 ms"
"""


def angles_exactly(times):
    """Angles (rad) of two uniform rods from below, by Lagrange's equations."""
    m1, m2 = M1 * L1, M2 * L2

    def slope(_, y):
        a, b, u, w = y
        c, s = np.cos(a - b), np.sin(a - b)
        mass = [
            [(m1 / 3 + m2) * L1**2, m2 * L1 * L2 * c / 2],
            [m2 * L1 * L2 * c / 2, m2 * L2**2 / 3],
        ]
        force = [
            -m2 * L1 * L2 * s * w**2 / 2 - (m1 / 2 + m2) * G * L1 * np.sin(a),
            m2 * L1 * L2 * s * u**2 / 2 - m2 * G * L2 * np.sin(b) / 2,
        ]
        return [u, w, *np.linalg.solve(mass, force)]

    start = [ANGLE, 0, 0, 0]
    found = solve_ivp(slope, (0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-12)
    return found.y[:2].T


def ends_exactly(times):
    """Places of both rods' lower ends, x and z of each."""
    a, b = angles_exactly(times).T
    first = np.stack([L1 * np.sin(a), -L1 * np.cos(a)], axis=1)
    return np.concatenate([first, first + L2 * np.stack([np.sin(b), -np.cos(b)], axis=1)], axis=1)


@pytest.mark.slow
def test_a_double_pendulum_moves_as_its_equations_say(tmp_path):
    errors, drifts, closures = [], [], []
    for step in ("5 ms", "2.5 ms", "1.25 ms"):
        ran = run_text(tmp_path, PENDULUM + f'[solver]\nstep = "{step}"\n')
        assert ran.statuses == ["OK"]
        ends = [ran[f"{name}.position"][0, :, 1][:, [0, 2]] for name in ("upper", "lower")]
        errors.append(np.max(np.abs(np.concatenate(ends, axis=1) - ends_exactly(ran.time))))
        for name, length in (("upper", L1), ("lower", L2)):
            rods = np.diff(ran[f"{name}.position"][0], axis=1)[:, 0]
            kept = np.linalg.norm(rods, axis=1)
            assert kept[0] == pytest.approx(length, rel=1e-6)
            drifts.append(np.max(np.abs(kept - kept[0])))
        closures.append(ran.outcomes[0].energy_closure)
    assert order_of(errors, 2.0) == pytest.approx([2.0, 2.0], abs=0.1)
    assert max(drifts) < 1e-10
    assert order_of(closures, 2.0) == pytest.approx([2.0, 2.0], abs=0.3)


def test_a_pendulum_pulls_at_its_pivot_as_it_should(tmp_path):
    # the upper rod's tension is the pull along it in the middle of a rod of spread mass; at the start,
    # all at rest: a_1, a_2 from the equations, and the force on the joint from the lower rod's motion
    ran = run_text(
        tmp_path,
        PENDULUM + '[solver]\nstep = "0.1 ms"\n',
        "output.duration=1 ms",
        "output.every=0.1 ms",
    )
    m1, m2, s, c = M1 * L1, M2 * L2, np.sin(ANGLE), np.cos(ANGLE)
    mass = [
        [(m1 / 3 + m2) * L1**2, m2 * L1 * L2 * c / 2],
        [m2 * L1 * L2 * c / 2, m2 * L2**2 / 3],
    ]
    turn, spin = np.linalg.solve(mass, [-(m1 / 2 + m2) * G * L1 * s, 0.0])
    # acceleration of the lower rod's middle, x and z, and the joint's force on it
    middle = np.array([L1 * c * turn + L2 / 2 * spin, L1 * s * turn])
    pull = m2 * (middle + np.array([0, G]))
    # along the upper rod: its own ends carry a third and a sixth of its mass, here at right angles
    along = np.array([s, -c])
    expected = -pull @ along + m1 / 2 * G * c
    assert ran["upper.tension"][0, 1, 0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_derivatives_through_the_constraints_are_those_of_differences(tmp_path):
    scene = scene_of(tmp_path, PENDULUM + '[solver]\nstep = "4 ms"\n')
    coordinates, layout = coordinates_of([scene]), make_layout(scene)
    numbers = {key: jnp.asarray(value) for key, value in scene.numbers().items()}

    def end(gravity):
        mine = scene.with_numbers(numbers | {"gravity": gravity})
        model = start_of(mine, layout, Coordinates(*coordinates)).model
        solver, term, dt = Constrained(), CableTerm(jnp.zeros(())), jnp.asarray(4e-3)
        y = initial_state(model, False, True)
        kept = solver.init(term, jnp.zeros(()), dt, y, model)

        def step(carry, i):
            y, kept = carry
            y, _, _, kept, _ = solver.step(term, i * dt, (i + 1) * dt, y, model, kept, False)
            return (y, kept), None

        (y, _), _ = jax.lax.scan(step, (y, kept), jnp.arange(100.0))
        return y.displacement["lower"][0, 1]

    end = jax.jit(end)
    h = 1e-4
    difference = (end(G + h) - end(G - h)) / (2 * h)
    assert jax.jvp(end, (G,), (1.0,))[1] == pytest.approx(float(difference), rel=1e-6)
    assert jax.grad(end)(G) == pytest.approx(float(difference), rel=1e-6)


def slid(folder, end, line, speed=0.0, volume=None):
    """The run, and the places (m) of a block with a line of `line` (kg) at its face."""
    text = sliding_block(
        speed=speed, end=end, line=line, volume=volume, step="1 ms", duration="1 s", every="1 ms",
        more='quantities = ["position", "energy"]',
    )  # fmt: skip
    ran = run_text(folder, text)
    assert ran.statuses == ["OK"]
    return ran, ran.bodies["block"]["position"][0, :, 0]


@pytest.mark.slow
def test_a_sliding_block_stops_where_coulomb_says_and_stays(tmp_path):
    # in water: (m - rho V) g on the bed, and friction of 0.4 of it; a gram of line hangs from it
    ran, x = slid(tmp_path, '"free"', 1e-3, speed=1.0, volume=0.4)
    slow = 0.4 * (1000 - 1000 * 0.4) * G / 1000
    stop = 1.0 / slow
    moving = ran.time < stop
    exact = np.where(moving, ran.time - slow * ran.time**2 / 2, stop / 2)
    assert x == pytest.approx(exact, abs=5e-6)  # the line, and half of dt^2 slow as it stops
    assert np.all(np.diff(x[~moving][2:]) == 0.0)
    friction = ran.energy["lost_friction"][0, -1]
    assert friction == pytest.approx(500.0, rel=1e-4)  # all of m v^2 / 2


@pytest.mark.parametrize(("x", "z"), [(1.0, 0.0), (0.8, 0.6)])
@pytest.mark.slow
def test_a_pulled_block_holds_up_to_its_friction_and_no_further(tmp_path, x, z):
    # f cos a = mu (W + w - f sin a) at the limit, with w the weight of the line, 1 kg
    weight = 1001 * G
    limit = 0.4 * weight / (x + 0.4 * z)
    for share in (0.999, 1.5):
        force = share * limit
        end = f"{{ held = {{ pretension = {force}, direction = [{x}, 0, {z}] }} }}"
        ran, place = slid(tmp_path, end, 1.0)
        if share < 1.0:
            assert np.all(place == place[0])
            continue
        gain = (force * x - 0.4 * (weight - force * z)) / 1001
        # the line, a thousandth of the mass, swings as it starts
        assert place - place[0] == pytest.approx(gain * ran.time**2 / 2, rel=2e-3, abs=1e-5)


RING = """
[materials.rod]
law = "inextensible"
[lines.a]
start = "c.end"
end = "b.start"
[lines.b]
start = "free"
end = "c.start"
[lines.c]
start = "free"
end = "free"
[output]
duration = "20 ms"
every = "2 ms"
[solver]
step = "1 ms"
"""


def test_rods_that_close_on_themselves_are_told_before_they_are_followed(tmp_path):
    own = '\nmaterial = "rod"\nlength = "10 m"\nsegments = 2\nmass = "1 kg/m"\nstart'
    with pytest.raises(SceneError, match=r"scene\.toml.*found a loop of a, b, c"):
        run_text(tmp_path, RING.replace("\nstart", own))


def test_rods_that_branch_are_told(tmp_path):
    third = PENDULUM[PENDULUM.index("[lines.lower]") : PENDULUM.index("[output]")]
    third = third.replace("lines.lower", "lines.third")
    with pytest.raises(SceneError, match="at most two ends"):
        run_text(tmp_path, PENDULUM + third + '[solver]\nstep = "2 ms"\n')


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('step = "2 ms"', "courant = 0.5", "solver.step", "found nothing"),
        ('step = "2 ms"', 'step = "2 ms"\nmethod = "rk4"', "solver.method", "leapfrog"),
        (
            'law = "inextensible"',
            'law = "inextensible"\ndamping = 3',
            "materials.stiff.damping",
            "no",
        ),
        ('joined = "lower.start"', 'joined = "lower.strat"', "lines.upper.end", '"lower.start"'),
        ("[output]", '[output]\nstop = "ship"', "output.stop", "velocity"),
    ],
)
def test_what_does_not_go_with_rods_is_told(tmp_path, old, new, key, words):
    text = PENDULUM + '[solver]\nstep = "2 ms"\n'
    assert old in text
    with pytest.raises(SceneError) as error:
        scene_of(tmp_path, text.replace(old, new))
    told = str(error.value)
    assert key in told
    assert words in told


RESTRAINT = (Path(__file__).parents[2] / "configs" / "restraint.toml").read_text()
RESTRAINT = RESTRAINT[: RESTRAINT.index("[[sweep.cases]]")]


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("friction = 0.3", "friction = -0.3", "bodies.anchor.friction", "non-negative"),
        # 16.8 m3 of water weigh 17.22 t
        ('mass = "40 t"', 'mass = "17 t"', "bodies.anchor.mass", "17220 kg"),
        # from the ring, 6.03393 m under water, to the bow, 1 m over it: sqrt(170^2 + 7.03393^2) m
        ('["138.0735 m"', '["145 m"', "lines.rod.length", "170.145 m"),
    ],
)
def test_a_restraint_that_cannot_be_is_told(tmp_path, old, new, key, words):
    assert old in RESTRAINT
    text = RESTRAINT.replace(old, new)
    with pytest.raises(SceneError) as error:
        scene_of(tmp_path, text)
    told = str(error.value)
    assert key in told
    assert words in told


BOUNCING = """
gravity = 9.81
[materials.stiff]
law = "inextensible"
EA = "100 kN"
[lines.rod]
material = "stiff"
length = "1 m"
segments = 1
mass = "1 g/m"
start = { fixed = [0, 0, "1.5 m"] }
end = "block.eye"
[bodies.block]
mass = "100 kg"
position = [0, 0, 0]
velocity = [0, 0, "-0.1 m/s"]
points = { eye = [0, 0, "0.5 m"] }
free = ["z"]
[output]
duration = "0.4 s"
every = "10 ms"
quantities = ["position", "energy", "tension"]
"""


@pytest.mark.slow
def test_rods_that_give_way_swing_as_a_spring(tmp_path):
    # (M + m/3) u'' = (M + m/2) g - EA u / l from u = 0, downwards
    errors, rod = [], 1e-3
    for step in ("1 ms", "0.5 ms", "0.25 ms"):
        ran = run_text(tmp_path, BOUNCING + f'[solver]\nstep = "{step}"\n')
        assert ran.statuses == ["OK"]
        w, sink = np.sqrt(1e5 / (100.0 + rod / 3.0)), (100.0 + 0.5 * rod) * G / 1e5
        exact = sink * (1.0 - np.cos(w * ran.time)) + 0.1 / w * np.sin(w * ran.time)
        u = -ran.bodies["block"]["position"][0, :, 2]
        errors.append(np.max(np.abs(u - exact)) / sink)
        # the tension is that of the stretch
        assert ran["rod.tension"][0, 5:, 0] == pytest.approx(1e5 * exact[5:], abs=10.0)
    assert errors[0] < 0.005
    assert order_of(errors, 2.0) == pytest.approx([2.0, 2.0], abs=0.15)
