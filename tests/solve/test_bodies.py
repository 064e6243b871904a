"""Rigid bodies: a rod on a spring, a floating box and a spinning top against their own equations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import order_of, run_text, scene_of
from scipy.integrate import solve_ivp

from lumpedcable.model.bodies import RigidBody
from lumpedcable.physics.rigid import rotation
from lumpedcable.scene import SceneError

G = 9.81
EA, LENGTH, WIRE = 2e3, 1.0, 0.02  # of the spring: N, m, kg/m
MASS, PITCH, ARM = 3.0, 1.0, 0.8  # of the rod: kg, kg m2, m from its middle to the end that hangs
START = np.array([0.9, -1.3, 0.3])  # x, z, pitch
ROD = f"""
gravity = {G}
[materials.spring]
law = "linear"
EA = {EA}
[lines.spring]
material = "spring"
length = {LENGTH}
segments = 1
mass = {WIRE}
start = {{ fixed = [0, 0, 0] }}
end = "rod.top"
[bodies.rod]
mass = {MASS}
position = [{START[0]}, 0, {START[1]}]
attitude = [0, {START[2]}, 0]
inertia = [5, {PITCH}, 5]
points = {{ top = [0, 0, {ARM}] }}
[output]
duration = "1 s"
every = "50 ms"
quantities = ["position", "velocity", "energy"]
"""


def rod_exactly(times):
    """x, z and pitch of the rod: three equations of motion, the wire's lower half a point at its top."""
    point = 0.5 * WIRE * LENGTH

    def slope(_, y):
        (x, z, p), (u, w, s) = y[:3], y[3:]
        # the top is at (x + b sin p, z + b cos p) and pitch turns z towards x
        top = np.array([x + ARM * np.sin(p), z + ARM * np.cos(p)])
        turn = np.array([[1, 0, ARM * np.cos(p)], [0, 1, -ARM * np.sin(p)]])
        inward = -(s**2) * ARM * np.array([np.sin(p), np.cos(p)])
        far = np.hypot(*top)
        pull = -EA * (far / LENGTH - 1) * top / far - point * G * np.array([0, 1])
        mass = np.diag([MASS, MASS, PITCH]) + point * turn.T @ turn
        force = np.array([0, -MASS * G, 0]) + turn.T @ (pull - point * inward)
        return np.concatenate([[u, w, s], np.linalg.solve(mass, force)])

    start = np.concatenate([START, np.zeros(3)])
    found = solve_ivp(slope, (0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-12)
    return found.y[:3].T


def coordinates(ran, body="rod"):
    """x, z and pitch over time."""
    mine = ran.bodies[body]
    return np.stack(
        [mine["position"][0, :, 0], mine["position"][0, :, 2], mine["attitude"][0, :, 1]], axis=1
    )


@pytest.mark.slow
def test_a_rod_on_a_spring_moves_as_its_equations_say(tmp_path):
    adaptive = '[solver]\nmethod = "dopri8"\nrtol = 1e-10\natol = 1e-11\n'
    ran = run_text(tmp_path, ROD + adaptive)
    assert ran.statuses == ["OK"]
    assert coordinates(ran) == pytest.approx(rod_exactly(ran.time), abs=1e-7)
    # the line ends where the rod is
    pitch = coordinates(ran)[:, 2]
    top = coordinates(ran)[:, :2] + ARM * np.stack([np.sin(pitch), np.cos(pitch)], axis=1)
    assert ran["spring.position"][0, :, -1][:, [0, 2]] == pytest.approx(top, abs=1e-12)
    assert ran.outcomes[0].energy_closure < 1e-8


@pytest.mark.slow
def test_leapfrog_is_of_second_order_with_a_body(tmp_path):
    errors = []
    for step in ("1 ms", "0.5 ms", "0.25 ms"):
        ran = run_text(tmp_path, ROD + f'[solver]\nstep = "{step}"\n')
        errors.append(np.max(np.abs(coordinates(ran) - rod_exactly(ran.time))))
    assert order_of(errors, 2.0) == pytest.approx([2.0, 2.0], abs=0.05)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow  # three compilations
def test_a_rod_in_an_upright_plane_askew_moves_as_in_xz(tmp_path):
    plain = run_text(tmp_path, ROD)
    turned = ROD.replace(f"position = [{START[0]}, 0,", f"position = [0, {START[0]},").replace(
        f"attitude = [0, {START[2]}, 0]", f"attitude = [{-START[2]}, 0, 0]"
    )
    turned = turned.replace(f"inertia = [5, {PITCH}, 5]", f"inertia = [{PITCH}, 5, 5]")
    other = run_text(tmp_path, turned)
    assert other.bodies["rod"]["position"][..., 1:] == pytest.approx(
        plain.bodies["rod"]["position"][..., [0, 2]], abs=1e-9
    )
    assert other.bodies["rod"]["attitude"][..., 0] == pytest.approx(
        -plain.bodies["rod"]["attitude"][..., 1], abs=1e-9
    )
    # and in space as in the plane
    space = run_text(tmp_path, "dimensions = 3\n" + ROD)
    for kind, values in plain.bodies["rod"].items():
        assert space.bodies["rod"][kind] == pytest.approx(values, abs=1e-9)


@pytest.mark.slow
def test_what_is_not_free_stays(tmp_path):
    ran = run_text(tmp_path, ROD.replace("inertia =", 'free = ["x"]\ninertia ='))
    moved = coordinates(ran) - START
    assert np.max(np.abs(moved[:, 1:])) == 0.0
    assert np.max(np.abs(moved[:, 0])) > 0.1


@pytest.mark.slow
def test_a_top_keeps_its_angular_momentum_and_its_energy():
    """Euler's equations in roll, pitch and yaw: no torque, three unequal moments of inertia."""
    body = RigidBody(jnp.zeros(6), jnp.full(3, 2.0), jnp.asarray([1.0, 2.0, 3.5]))

    def slope(_, y):
        q, v = jnp.asarray(y[:6]), jnp.asarray(y[6:])
        gain = jnp.linalg.solve(body.mass(q), body.force(q, v))
        return np.concatenate([v, gain])

    def momentum(y):
        # in space: R I R^T times the angular velocity, the axial vector of (dR/dt) R^T
        q, v = jnp.asarray(y[:6]), jnp.asarray(y[6:])
        turn, rate = jax.jvp(rotation, (q[3:],), (v[3:],))
        spin = rate @ turn.T
        omega = jnp.asarray([spin[2, 1], spin[0, 2], spin[1, 0]])
        return np.asarray(turn @ (body.inertia * (turn.T @ omega)))

    start = np.array([0, 0, 0, 0.2, -0.3, 0.1, 1.0, 0, 0, 0.5, 0.4, -0.6])
    found = solve_ivp(slope, (0, 2), start, rtol=1e-9, atol=1e-10)
    assert momentum(found.y[:, -1]) == pytest.approx(momentum(start), abs=1e-7)
    energies = [0.5 * y[6:] @ np.asarray(body.mass(jnp.asarray(y[:6]))) @ y[6:] for y in found.y.T]
    assert energies[-1] == pytest.approx(energies[0], rel=1e-7)
    assert found.y[3:6, -1] != pytest.approx(start[3:6], abs=0.5)


SHIP = """
gravity = 9.81
[water]
density = "1025 kg/m3"
[materials.thread]
law = "linear"
EA = "1 N"
[lines.thread]
material = "thread"
length = "100 m"
segments = 1
mass = "1 g/m"
diameter = "1 mm"
start = {{ fixed = [0, 0, 80] }}
end = "ship"
[bodies.ship]
mass = "500 t"
size = ["50 m", "10 m", "5 m"]
position = [0, 0, {z}]
attitude = [0, {pitch}, 0]
hull = {{ above_keel = "1.2 m" }}
[output]
duration = "12 s"
every = "20 ms"
[solver]
step = "20 ms"
"""
DRAUGHT = 500e3 / (1025 * 50 * 10)


def period_of(times, values):
    """Mean time between rising zero crossings, linear between samples."""
    rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    share = values[rising] / (values[rising] - values[rising + 1])
    crossings = times[rising] + share * (times[rising + 1] - times[rising])
    return np.mean(np.diff(crossings))


def test_a_box_floats_and_heaves_and_pitches_in_its_own_time(tmp_path):
    # Archimedes: it floats at 1.2 m - T; heave 2 pi sqrt(T/g); pitch 2 pi sqrt(I / (m g GM))
    lift, tilt = 0.1, 0.01
    ran = run_text(tmp_path, SHIP.format(z=1.2 - DRAUGHT + lift, pitch=tilt))
    assert ran.statuses == ["OK"]
    heave = ran.bodies["ship"]["position"][0, :, 2] - (1.2 - DRAUGHT)
    pitch = ran.bodies["ship"]["attitude"][0, :, 1]
    assert heave[0] == pytest.approx(lift)
    assert pitch[0] == pytest.approx(tilt)
    metacentre = DRAUGHT / 2 + 50**2 / (12 * DRAUGHT) - 1.2
    inertia = 500e3 * (50**2 + 5**2) / 12
    exact = 2 * np.pi * np.sqrt(inertia / (500e3 * G * metacentre))
    # leapfrog's period is short by (w dt)^2 / 24: 2e-4 here
    assert period_of(ran.time, heave) == pytest.approx(2 * np.pi * np.sqrt(DRAUGHT / G), rel=3e-4)
    assert period_of(ran.time, pitch) == pytest.approx(exact, rel=3e-4)
    assert np.max(heave[len(heave) // 2 :]) == pytest.approx(lift, rel=0.01)


def decay(time, start, mass, damping, stiffness, push=0.0):
    """x of m x'' + c x' + k x = push from x = start at rest, less than critically damped."""
    rate, rest = damping / (2 * mass), push / stiffness
    omega = np.sqrt(stiffness / mass - rate**2)
    swing = np.cos(omega * time) + rate / omega * np.sin(omega * time)
    return rest + (start - rest) * np.exp(-rate * time) * swing


@pytest.mark.slow
def test_a_free_ship_in_six_freedoms_decays_as_six_oscillators_do(tmp_path):
    # small motions about the upright ship hardly couple: each freedom is a spring, a damper, a push
    text = SHIP.replace("attitude = [0, {pitch}, 0]", "attitude = [0.002, {pitch}, 0.001]")
    text = (
        "dimensions = 3\n"
        + text.format(z=1.2 - DRAUGHT + 0.1, pitch=0.001)
        + """
[bodies.ship.control]
force = ["3 kN", "3 kN", 0]
moment = [0, 0, "30 kN m"]
stiffness = ["200 kN/m", "300 kN/m", 0]
damping = ["100 kN s/m", "60 kN s/m", "80 kN s/m"]
turn_stiffness = [0, 0, "50 MN m/rad"]
turn_damping = ["0.5 MN m s/rad", "10 MN m s/rad", "20 MN m s/rad"]
"""
    )
    ran = run_text(tmp_path, text, "solver.step=10 ms")
    assert ran.statuses == ["OK"]
    mass, t = 500e3, ran.time
    turned = mass / 12 * np.array([10**2 + 5**2, 50**2 + 5**2, 50**2 + 10**2])
    metacentres = [DRAUGHT / 2 + side**2 / (12 * DRAUGHT) - 1.2 for side in (10, 50)]
    place, angle = (ran.bodies["ship"][k][0] for k in ("position", "attitude"))
    place[:, 2] -= 1.2 - DRAUGHT
    exact = [
        (place[:, 0], decay(t, 0, mass, 100e3, 200e3, 3e3)),
        (place[:, 1], decay(t, 0, mass, 60e3, 300e3, 3e3)),
        (place[:, 2], decay(t, 0.1, mass, 80e3, mass * G / DRAUGHT)),
        (angle[:, 0], decay(t, 0.002, turned[0], 0.5e6, mass * G * metacentres[0])),
        (angle[:, 1], decay(t, 0.001, turned[1], 10e6, mass * G * metacentres[1])),
        (angle[:, 2] - 0.001, decay(t, 0, turned[2], 20e6, 50e6, 3e4)),
    ]
    for found, wanted in exact:
        assert np.max(np.abs(found - wanted)) < 1e-2 * np.ptp(wanted)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('end = "rod.top"', 'end = "rod.tip"', "lines.spring.end", 'did you mean "top"'),
        (f"position = [{START[0]}, 0, {START[1]}]\n", "", "bodies.rod.position", "found nothing"),
        (f"inertia = [5, {PITCH}, 5]\n", "", "bodies.rod.inertia", "found neither"),
        ("[bodies.rod]", "[bodies.spring]", "bodies.spring", "a line as well"),
        ("points =", "hull = {}\npoints =", "bodies.rod.size", "of a hull"),
        ("points =", 'free = ["x", "x"]\npoints =', "bodies.rod.free", "once"),
        ("points =", 'free = ["pich"]\npoints =', "bodies.rod.free", '"pich"'),
    ],
)
def test_a_wrong_body_is_told(tmp_path, old, new, key, words):
    assert old in ROD
    with pytest.raises(SceneError) as error:
        scene_of(tmp_path, ROD.replace(old, new))
    told = str(error.value)
    assert key in told
    assert words in told
