"""Lines that stick to the bed and slide on it, by Coulomb's law: against closed forms."""

import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, line_text, run_text, scene_of, sliding_block

from lumpedcable.model.motion import kick
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError

G, MASS, MU = 10.0, 100.0, 0.5  # m/s2, kg/m, -
SHARE = MU * MASS * G  # N per m of line that slides
BED = f"""
gravity = {G}
[seabed]
height = 0
stiffness = "1 MPa"
damping = "5 kPa s"
friction = {MU}
"""
ELASTIC = '[materials.wire]\nlaw = "linear"\nEA = {EA}\n'
RODS = '[materials.wire]\nlaw = "inextensible"\n[solver]\nstep = "2 ms"\n'
OUTPUT = """
[output]
duration = {duration}
every = {every}
quantities = ["position", "velocity", "tension", "energy"]
"""


def line(length, segments, start, end, mass=MASS):
    return line_text("wire", "wire", length, segments, mass, start, end)


@pytest.mark.slow
def test_what_is_pulled_slides_as_far_as_friction_asks(tmp_path):
    # pulled slowly by u, the line slides over s with T = EA u' falling by mu w per metre:
    # u = mu w s^2 / (2 EA), T(x) = mu w (x - 50 m) where it slides; held there, it stays as it is
    EA, far, slid = 1e7, 100.0, 50.0
    pulled = SHARE * slid**2 / (2 * EA)
    times = [*np.linspace(0.0, 6.25, 26).tolist(), 6.5, 6.75, 9.0]
    places = [[float(far + x), 0.0, 0.0] for x in [*np.linspace(0.0, pulled, 26), *3 * [pulled]]]
    text = BED + ELASTIC.format(EA=EA)
    moved = f"{{ motion = {{ time = {times}, position = {places} }} }}"
    text += line(far, 50, "{ fixed = [0, 0, 0] }", moved)
    ran = run_text(tmp_path, text + OUTPUT.format(duration=9, every=0.25))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-4
    tension = ran["tension"][0]
    middles = np.arange(1.0, 100.0, 2.0)
    exact = SHARE * np.maximum(middles - slid, 0.0)
    # half a metre's share: lumps, and what inertia adds
    assert tension[25] == pytest.approx(exact, abs=0.5 * SHARE)
    assert np.ptp(tension[-6:], axis=0) == pytest.approx(0.0, abs=1e-6)
    assert np.all(ran["velocity"][0, -6:, 1:-1, 0] == 0.0)


def slid(folder, EA, end, line, speed=0.0):
    """The run, and the places (m) of a block of 1 t with an elastic line of `line` (kg)."""
    text = sliding_block(
        speed=speed, end=end, line=line, step="0.5 ms", duration="0.5 s", every="1 ms",
        more='quantities = ["position", "energy"]',
    )  # fmt: skip
    ran = run_text(folder, text.replace('"inextensible"', f'"linear"\nEA = {EA}'))
    assert ran.statuses == ["OK"]
    return ran, ran.bodies["block"]["position"][0, :, 0]


@pytest.mark.slow
def test_a_block_with_an_elastic_line_stops_where_coulomb_says_and_stays(tmp_path):
    ran, x = slid(tmp_path, 10.0, '"free"', 1e-3, speed=1.0)
    slow = 0.4 * 9.81
    stop = 1.0 / slow
    moving = ran.time < stop
    exact = np.where(moving, ran.time - slow * ran.time**2 / 2, stop / 2)
    assert x == pytest.approx(exact, abs=5e-6)  # the line, and half of dt^2 slow as it stops
    assert np.all(np.diff(x[~moving][2:]) == 0.0)
    assert ran.energy["lost_friction"][0, -1] == pytest.approx(500.0, rel=1e-4)
    assert ran.outcomes[0].energy_closure < 1e-5


@pytest.mark.parametrize("share", [0.999, 1.5])
def test_a_block_holds_up_to_its_friction_and_no_further(tmp_path, share):
    # f cos a = mu (W + w - f sin a) at the limit, with w the weight of the line, 1 kg
    weight = 1001 * 9.81
    force = share * 0.4 * weight / (0.8 + 0.4 * 0.6)
    end = f"{{ held = {{ pretension = {force}, direction = [0.8, 0, 0.6] }} }}"
    ran, x = slid(tmp_path, 2e5, end, 1.0)
    if share < 1.0:
        assert np.all(x == x[0])
        return
    gain = (force * 0.8 - 0.4 * (weight - force * 0.6)) / 1001
    # the line, a thousandth of the mass, stretches and swings as it starts
    assert x - x[0] == pytest.approx(gain * ran.time**2 / 2, rel=2e-3, abs=1e-5)


PULLED = (
    BED
    + RODS
    + """
[bodies.sled]
mass = "100 kg"
position = [20, 0, 0]
points = { eye = [0, 0, 0] }
free = ["x"]
control = { force = [1, 0, 0] }
"""
)


@pytest.mark.slow
def test_rods_hold_up_to_their_friction_and_no_further(tmp_path):
    # up to mu w L nothing moves; beyond it (F - mu w L) / (M + m L), and T falls along the line
    whole = SHARE * 19.0  # the node at the sled, a metre of it, is carried
    text = PULLED + line(20.0, 10, '"free"', '"sled.eye"') + OUTPUT.format(duration=2, every=0.1)
    text += f'[sweep]\n"bodies.sled.control.force.0" = [{0.95 * whole}, {1.5 * whole}]\n'
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK", "OK"]
    x = ran.bodies["sled"]["position"][:, :, 0]
    # what sticks gives mu g dt^2, twice that as the load comes at once, and does not creep
    assert 0.0 < x[0, -1] - x[0, 0] < 2.0 * MU * G * 2e-3**2
    assert np.ptp(x[0, 10:]) < 1e-13
    assert np.sum(ran["tension"][0, -1, -1]) == pytest.approx(-0.95 * whole, rel=1e-3)
    mass, dt = 100.0 + 20.0 * MASS, 2e-3
    gain = 0.5 * whole / mass
    # a step late at most
    assert x[1] - x[1, 0] == pytest.approx(gain * ran.time**2 / 2, abs=gain * 2.0 * dt)
    middles = np.arange(1.0, 20.0, 2.0)
    behind = SHARE * middles + gain * MASS * middles
    assert -ran["tension"][1, -1] == pytest.approx(behind, abs=5.0)
    lost = ran.energy["lost_friction"][1, -1]
    assert lost == pytest.approx(whole * (x[1, -1] - x[1, 0]), rel=1e-3)


SWAYED = """
gravity = 9.81
[water]
density = 1025
current = {{ velocity = [0.4, 0.5, 0] }}
[seabed]
height = -8
stiffness = 1e5
damping = 500
{friction}
[materials.wire]
law = "inextensible"
[lines.chain]
material = "wire"
length = 40
segments = 8
mass = 10
diameter = 0.06
drag = {{ normal = 1.2, tangential = 0.1 }}
added_mass = {{ normal = 1.0, tangential = 0.2 }}
{first} = {{ fixed = [0, 0, -8] }}
{last} = {{ motion = {{ position = [36, 0, 0], amplitude = [0.5, 1.5, 0.8], period = 4, ramp = 1 }} }}
[solver]
step = "1 ms"
[output]
duration = 2
every = 0.01
"""
ONE_WAY, OTHER_WAY = {"first": "start", "last": "end"}, {"first": "end", "last": "start"}


def peak(folder, ran):
    assert ran.statuses == ["OK"]
    # of every step, not of the output times alone
    with open_result(folder / "result.h5") as found:
        return found.summary()["run"]["peak_tension"][0]


@pytest.mark.slow
def test_tensions_of_rods_that_stick_and_slide_do_not_depend_on_the_step(tmp_path):
    # the bed takes at most mu w L of a chain that is swayed on it, and what is left is as without it
    plain = peak(tmp_path, run_text(tmp_path, SWAYED.format(friction="", **ONE_WAY)))
    weight = (10.0 - 1025.0 * np.pi / 4.0 * 0.06**2) * 9.81
    text = SWAYED.format(friction="friction = 0.5", **ONE_WAY)
    runs, peaks = [], []
    for step in (2e-3, 1e-3, 2.5e-4):
        runs.append(run_text(tmp_path, text, f"solver.step={step}"))
        peaks.append(peak(tmp_path, runs[-1]))
    assert plain < peaks[1] < plain + 0.5 * weight * 40.0
    assert peaks == pytest.approx(3 * [peaks[1]], rel=2e-3)
    # nor on the end that the line is counted from
    other = run_text(tmp_path, SWAYED.format(friction="friction = 0.5", **OTHER_WAY))
    assert other["tension"][0, :, ::-1] == pytest.approx(runs[1]["tension"][0], rel=1e-3, abs=1.0)


@pytest.mark.slow
def test_a_line_that_is_let_go_coasts_as_far_as_friction_lets_it(tmp_path):
    # towed at v with T falling by mu w per metre, then cut loose: its middle goes on by v^2 / (2 mu g)
    speed, length, EA = 2.0, 20.0, 1e8
    moved = f"{{ motion = {{ position = [0, 0, 0], velocity = [{-speed}, 0, 0], ramp = 1 }} }}"
    text = (
        BED + ELASTIC.format(EA=EA) + 'damping = "200 kN s"\n' + line(length, 40, moved, '"free"')
    )
    text += '[events.cut]\nbreaks = "wire.start"\ntime = 0\nstart = 2.5\n'
    ran = run_text(tmp_path, text + OUTPUT.format(duration=3.25, every=0.25))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
    cut = 9
    behind = SHARE * (length - np.arange(0.25, length, 0.5))
    assert ran["tension"][0, cut] == pytest.approx(behind, abs=0.1 * SHARE)
    middle = ran["position"][0, :, :, 0] @ (np.r_[0.5, np.ones(39), 0.5] / 40.0)
    way = speed * 0.25 + speed**2 / (2.0 * MU * G)
    # it shortens by mu w L^2 / (2 EA) = 1 mm meanwhile
    assert middle[cut] - middle[-1] == pytest.approx(way, abs=3e-3)
    assert np.all(ran["velocity"][0, -1, :, 0] == 0.0)


@pytest.mark.slow
def test_friction_is_against_the_velocity_however_the_water_weighs_on_a_line(tmp_path):
    # along the line a node weighs 100 kg/m, across it twice that: its momentum has another direction
    text = "dimensions = 3\n" + BED + "[water]\ndensity = 1000\n" + ELASTIC.format(EA=1e7)
    text += line_text(
        "wire", "wire", 8.0, 8, MASS, "{ fixed = [0, 0, 0] }", "{ fixed = [8, 0, 0] }",
        f"diameter = {np.sqrt(0.2 / np.pi)}\nadded_mass = {{ normal = 2.0 }}",
    )  # fmt: skip
    text += OUTPUT.format(duration=1, every=1)
    model = equilibrium_of(scene_of(tmp_path, text))[0].model
    start = jnp.zeros_like(model.lines["wire"].reference)
    for dt in (1e-4, 0.05):
        before = start.at[:2, 1:-1].set(jnp.array([[0.3], [0.4]]))
        kicked = kick(model, jnp.zeros(()), {"wire": start}, {"wire": before}, {}, jnp.asarray(dt))
        node = slice(2, -2)
        force = np.asarray(kicked.found["wire"].grip)[:2, node]
        after = np.asarray(kicked.after["wire"])[:2, node]
        speed = np.hypot(*after)
        assert np.all(speed > 0.0)
        # the water lifts half of the weight
        np.testing.assert_allclose(force, -0.5 * SHARE * after / speed, rtol=1e-9)
        masses = np.array([[100.0], [200.0]])
        np.testing.assert_allclose(masses * (after - [[0.3], [0.4]]), force * dt, rtol=1e-6)


SLOPE = 0.5  # tan a, from x = 10 m on; level before
COS, SIN = 1.0 / np.hypot(1.0, SLOPE), SLOPE / np.hypot(1.0, SLOPE)
BANK = BED.replace(
    "height = 0", "height = 0\nprofile = {{ x = [0, 10, 30, 100], depth = [0, 5, 15, 50] }}"
).replace("friction = 0.5", "friction = {friction}")
TOP = "{ fixed = [10, 0, -5] }"


def hanging(x, z, tension):
    """What a line at rest on the slope must have, without friction: its places and tensions.

    T = w sin a per metre, and the bed carries w cos a along its normal, which is w cos^2 a upwards; that
    is how deep it sinks, with half the blend, which is at 9.80665 m/s2.
    """
    middles = np.arange(1.0, 20.0, 2.0)
    assert tension == pytest.approx(MASS * G * SIN * (20.0 - middles), rel=1e-3)
    sunk = (MASS * G * COS**2 + 0.1 * MASS * 9.80665) / 1e6
    assert -SLOPE * x - z == pytest.approx(sunk, rel=1e-4)


@pytest.mark.slow
def test_rods_rest_on_a_slope(tmp_path):
    text = BANK.format(friction=0.3) + RODS + line(20.0, 10, TOP, '"free"')
    ran = run_text(tmp_path, text + OUTPUT.format(duration=0.2, every=0.1))
    assert ran.statuses == ["OK"]
    for k in (0, -1):
        hanging(*ran["position"][0, k, 3:].T[[0, 2]], ran["tension"][0, k])


@pytest.mark.slow
def test_a_line_slides_down_where_the_slope_is_steeper_than_its_friction(tmp_path):
    # cut loose at the top: g (sin a - mu cos a) if tan a > mu, else it stays; at first it shortens by
    # w sin a L^2 / (2 EA) = 0.9 mm, and is given a push by it
    text = BANK.format(friction=0.3) + ELASTIC.format(EA=1e8) + 'damping = "200 kN s"\n'
    text += line(20.0, 10, TOP, '"free"') + '[events.cut]\nbreaks = "wire.start"\ntime = 0\n'
    text += OUTPUT.format(duration=1.0, every=0.1) + '[sweep]\n"seabed.friction" = [0.3, 0.6]\n'
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK", "OK"]
    hanging(*ran["position"][0, 0, 3:].T[[0, 2]], ran["tension"][0, 0])
    along = ran["position"] @ [COS, 0.0, -SIN]
    slides, stays = along @ (np.r_[0.5, np.ones(9), 0.5] / 10.0)
    gain = G * (SIN - 0.3 * COS)
    assert np.diff(slides, 2)[3:] == pytest.approx(gain * 0.1**2, rel=1e-4)
    assert 0.0 < stays[-1] - stays[0] < 0.9e-3
    assert np.max(np.abs(ran["velocity"][1, -3:] @ [COS, 0.0, -SIN])) < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("friction = 0.5", "friction = -0.5", "seabed.friction", "non-negative"),
        (
            "friction = 0.5",
            "profile = { x = [0, 1], depth = [2] }",
            "seabed.profile.depth",
            "found 1",
        ),
        (
            "friction = 0.5",
            "profile = { x = [0, 2, 1], depth = [2, 2, 2] }",
            "seabed.profile.x.2",
            "more than 2 m",
        ),
        ('step = "2 ms"', 'method = "rk4"', "seabed.friction", '"rk4"'),
        ("friction = 0.5", "profile = { x = [0, 50], depth = [0, -20] }", "bodies.sled", "8 m"),
    ],
)
def test_a_bed_that_cannot_be_is_told(tmp_path, old, new, key, words):
    text = PULLED + line(20.0, 10, '"free"', '"sled.eye"') + OUTPUT.format(duration=2, every=0.1)
    assert old in text
    with pytest.raises(SceneError) as error:
        scene_of(tmp_path, text.replace(old, new))
    assert key in str(error.value)
    assert words in str(error.value)


@pytest.mark.slow
def test_rods_on_a_bed_tell_of_a_step_that_it_does_not_bear(tmp_path):
    # ends of rods that bounce against each other move a third of the mass: omega^2 = 3 k / m, and
    # leapfrog bears omega dt = 2
    most = 2.0 / np.sqrt(3.0 * 1e6 / MASS)
    bed = BED.replace('damping = "5 kPa s"\n', "").replace(f"friction = {MU}\n", "")
    text = bed + RODS + line(20.0, 20, "{ fixed = [0, 0, 0.1] }", '"free"')
    text += OUTPUT.format(duration=4, every=0.2)
    ended = [run_text(tmp_path, text, f"solver.step={s * most}") for s in (0.95, 1.05)]
    assert [ran.statuses for ran in ended] == [["OK"], ["STEP_BOUND_BROKEN"]]
    # the one bounces as little as at its start, the other as much as leapfrog makes it
    low, high = (np.max(np.abs(np.diff(ran["velocity"][0, :, 1:, 2], axis=1))) for ran in ended)
    assert low < 1e-3
    assert not high < 1.0


def test_a_method_that_knows_no_friction_of_bodies_is_told(tmp_path):
    text = sliding_block(speed=1.0, step="1 ms", duration="1 s", every="1 s")
    text = text.replace('"inextensible"', '"linear"\nEA = 10')
    text = text.replace('step = "1 ms"', 'step = "1 ms"\nmethod = "rk4"')
    with pytest.raises(SceneError, match=r"bodies\.block\.friction") as error:
        scene_of(tmp_path, text)
    assert '"leapfrog"' in str(error.value)


LIFTED = """
gravity = 9.81
[water]
density = 1025
[seabed]
height = 0
stiffness = 2e4
damping = 500
friction = 0.8
[materials.r]
law = "linear"
EA = 2e5
tension_only = true
damping = 50
[lines.c]
material = "r"
length = 9
segments = 3
mass = 4
diameter = 0.06
drag = { normal = 1.4, tangential = 0.05 }
added_mass = { normal = 1 }
start = { fixed = [0, 0, 0] }
end = { motion = { position = [7, 0, 2.5], velocity = [0.5, 0, 0], ramp = 1 } }
[solver]
step = 0.002
[output]
duration = 2
every = 0.1
"""


@pytest.mark.slow
def test_what_lifts_off_slides_alike_in_a_plane_and_in_space(tmp_path):
    """Added mass across the line makes its inertia along the bed one of both, as it lifts off."""
    plane, space = (run_text(tmp_path, f"dimensions = {d}\n{LIFTED}") for d in (2, 3))
    lost = [ran.energy["lost_friction"][0, -1] for ran in (plane, space)]
    assert lost[0] > 1.0
    assert lost[0] == pytest.approx(lost[1], rel=1e-8)
    np.testing.assert_allclose(plane.places["c"], space.places["c"], atol=1e-9)
    assert plane.outcomes[0].energy_closure < 1e-3
