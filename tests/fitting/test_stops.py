"""When a body comes to rest, and what rods carry between outputs: values and derivatives, exactly."""

import numpy as np
import pytest
from engine_runs import sliding_block, study_of

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes
from lumpedcable.status import Status

G, MU, SPEED, VOLUME, DENSITY = 9.81, 0.4, 1.0, 0.4, 1000.0
TOW = 1e-6  # kg of a metre of line 1 mm thick, which the water carries as well
BLOCK = sliding_block(
    speed=SPEED, face=0, volume=VOLUME, line=TOW, step="2 ms", duration="0.5 s", every="20 ms",
    more='stop = "block"\n',
)  # fmt: skip
MASS = 1000.0 + TOW
WEIGHT = MASS - DENSITY * (VOLUME + 0.25 * np.pi * 1e-6)  # kg on the bed
SLOWING = MU * G * WEIGHT / MASS
KEYS = (
    "bodies.block.friction", "bodies.block.velocity.0", "bodies.block.mass", "gravity",
    "water.density",
)  # fmt: skip
# t = v m / (mu g (m - rho V)): relative derivatives by the numbers above
BY_MASS, BY_WATER = 1.0 - MASS / WEIGHT, DENSITY * VOLUME / WEIGHT


def found(folder, text, of, keys):
    """A scalar and its relative derivatives."""
    study = study_of(folder, text)
    at = np.array([study.scene.numbers()[key] for key in keys])
    value, status, slopes = scalar_slopes(study, read_scalar(of, study.scene), keys, at)
    assert status is Status.OK
    return value, slopes * at / value


@pytest.mark.parametrize(
    ("of", "exact", "shares"),
    [
        ("stop time", SPEED / SLOWING, (-1.0, 1.0, BY_MASS, -1.0, BY_WATER)),
        (
            "last displacement at block",
            SPEED**2 / (2.0 * SLOWING),
            (-1.0, 2.0, BY_MASS, -1.0, BY_WATER),
        ),
    ],
)
@pytest.mark.slow
def test_a_block_stops_when_and_where_coulomb_says(tmp_path, of, exact, shares):
    value, told = found(tmp_path, BLOCK, of, KEYS)
    # what is left is the line's swing, of a thousandth of a millionth of the mass
    assert value == pytest.approx(exact, rel=1e-8)
    assert told == pytest.approx(shares, abs=3e-6)


def test_a_stop_that_the_scene_does_not_have_is_told(tmp_path):
    with pytest.raises(ValueError, match=r'expected output\.stop = "BODY"'):
        found(tmp_path, BLOCK.replace('stop = "block"\n', ""), "stop time", KEYS[:1])


@pytest.mark.slow
def test_a_stop_that_does_not_come_is_told(tmp_path):
    short = BLOCK.replace('duration = "0.5 s"', 'duration = "0.1 s"')
    with pytest.raises(ValueError, match=r"come to rest within output\.duration"):
        found(tmp_path, short, "stop time", KEYS[:1])


LENGTH, BOB = 1.0, 5.0  # m, kg
PENDULUM = f"""
gravity = {G}
[materials.stiff]
law = "inextensible"
[lines.rod]
material = "stiff"
length = {LENGTH}
segments = 1
mass = 1e-9
start = {{ fixed = [0, 0, 0] }}
end = "bob"
[bodies.bob]
mass = {BOB}
size = [0.1, 0.1, 0.1]
position = [0, 0, {-LENGTH}]
velocity = [{SPEED}, 0, 0]
free = ["x", "z"]
[solver]
step = "1 ms"
[output]
duration = "0.5 s"
every = "0.25 s"
"""


@pytest.mark.slow
def test_the_peak_of_a_joints_force_is_that_of_every_step(tmp_path):
    # m (g + v^2 / L) at the bottom, where it starts; outputs see it a quarter of a second later
    turn = SPEED**2 / LENGTH
    keys = ("bodies.bob.mass", "bodies.bob.velocity.0", "gravity")
    value, shares = found(tmp_path, PENDULUM, "peak tension at bob", keys)
    # the first step ends an angle v dt / L away from the bottom, where m g cos and m v^2 / L are less
    less = 1.5 * G * (SPEED * 1e-3 / LENGTH) ** 2
    assert value == pytest.approx(BOB * (G + turn - less), rel=3e-7)
    wanted = (1.0, 2.0 * turn / (G + turn), G / (G + turn))
    assert shares == pytest.approx(wanted, abs=3.0 * less / (G + turn))


@pytest.mark.parametrize(
    ("of", "said"),
    [
        ("peak velocity at rod.end", "take max"),
        ("peak tension at rid.end", 'found "rid"'),
        ("peek tension at rod.end", "peek"),
    ],
)
def test_a_peak_that_there_is_not_is_told(tmp_path, of, said):
    study = study_of(tmp_path, PENDULUM)
    with pytest.raises(ValueError, match=said):
        scalar_slopes(study, read_scalar(of, study.scene), ("gravity",), np.array([G]))
