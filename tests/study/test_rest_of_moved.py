"""Scenes at rest with what would move: everything at its mean place, and nothing has a speed."""

import numpy as np
import pytest

from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.moved import moved_ships
from lumpedcable.study.resting import Resting
from lumpedcable.study.run import run_study

# a mooring line of a damped material up to a ship, without a seabed
MOORED = """\
gravity = "9.81 m/s2"

[sea]
height = "4 m"
period = "10 s"

[materials.chain]
law = "linear"
EA = "600 MN"
damping = "5 MN s"
breaking_strength = "6 MN"

[lines.leg]
material = "chain"
length = "200 m"
segments = 10
mass = "145 kg/m"
start = { fixed = [0, 0, "-100 m"] }
end = END

[bodies.ship]
position = ["160 m", 0, 0]
points = { fairlead = ["-20 m", 0, "-5 m"] }
motion = MOTION

[output]
TIMES
"""
SHIP = '"ship.fairlead"'
LASTS = 'duration = "1 s"\nevery = "0.1 s"'
STILL = '{ heave = { amplitude = 0, period = "10 s" } }'
RAO = (
    "{ omega = [0.1, 3], response.heave = [[1, 0], [1, 0]], response.surge = [[0.9, -1.5], [0.9, -1.5]],"
    " response.pitch = [[0.02, 1], [0.02, 1]] }"
)
SWING = '{ heave = { amplitude = "2 m", period = "9 s", phase = "60 deg" } }'
RECORD = '{ time = [0, 1, 2], heave = ["1 m", "2 m", "1.5 m"], pitch = [0.02, 0.03, 0.01] }'
MOTIONS = {"in waves": RAO, "a swing": SWING, "a record": RECORD}
EACH = [
    pytest.param(motion, id=name, marks=() if name == "a record" else pytest.mark.slow)
    for name, motion in MOTIONS.items()
]


def scene_of(folder, motion, times="", end=SHIP):
    text = MOORED.replace("MOTION", motion).replace("TIMES", times).replace("END", end)
    (folder / "scene.toml").write_text(text)
    return load_study(folder / "scene.toml")


def seen(folder, *args, **kwargs):
    """The leg at t = 0: places (m), velocities (m/s), tensions (N), and its numbers at rest."""
    (outcome,) = run_study(scene_of(folder, *args, **kwargs), folder / "r.h5")
    assert outcome.status.name == "OK"
    with open_result(folder / "r.h5") as result:
        line = result.line("leg")
        fields = [line.field(key)[0, 0] for key in ("position", "velocity", "tension")]
        return fields, result.rest("leg") if result.cables else {}, result.summary()["run"]


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory):
    return seen(tmp_path_factory.mktemp("rest"), STILL)


@pytest.mark.parametrize("motion", EACH)
@pytest.mark.slow
def test_a_ship_is_at_its_position_without_speed(tmp_path, at_rest, motion):
    (place, speed, tension), numbers, summary = seen(tmp_path, motion)
    (still, _, pull), expected, alike = at_rest
    np.testing.assert_allclose(place[-1], [140.0, 0.0, -5.0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(place, still, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(speed, 0.0)
    np.testing.assert_allclose(tension, pull, rtol=1e-9)
    assert numbers.keys() == expected.keys()
    for key, value in numbers.items():
        assert value == pytest.approx(expected[key], rel=1e-9, nan_ok=True), key
    assert summary["utilisation"] == pytest.approx(alike["utilisation"], rel=1e-9)


@pytest.mark.parametrize("motion", EACH)
@pytest.mark.slow
def test_a_run_starts_where_the_motion_is_at_t_0(tmp_path, at_rest, motion):
    (place, speed, _), _, _ = seen(tmp_path, motion, LASTS)
    study = scene_of(tmp_path, motion, LASTS)
    ship = moved_ships(study.scene, np.array([0.0, 1e-5]))["ship"]
    assert np.linalg.norm(ship.position[0] - [160.0, 0.0, 0.0]) > 0.1
    pitch = ship.attitude[0, 1]
    arm = [-20.0 * np.cos(pitch) - 5.0 * np.sin(pitch), 20.0 * np.sin(pitch) - 5.0 * np.cos(pitch)]
    at = ship.position[0] + [arm[0], 0.0, arm[1]]
    np.testing.assert_allclose(place[-1], at, rtol=0, atol=1e-9)
    assert np.linalg.norm(speed[-1]) > 0.1


RAMPED = RAO.replace(" }", ', ramp = "5 s" }')


def test_a_ramp_starts_the_motion_of_a_ship_from_its_position(tmp_path):
    study = scene_of(tmp_path, RAMPED, LASTS)
    ship = moved_ships(study.scene, np.array([0.0, 1e-5]))["ship"]
    np.testing.assert_array_equal(ship.position[0], [160.0, 0.0, 0.0])
    np.testing.assert_array_equal(ship.attitude[0], 0.0)
    # without speed: 1e-5 s on it has come by the square of 2e-6 of the ramp
    np.testing.assert_allclose(ship.position[1], [160.0, 0.0, 0.0], rtol=0, atol=1e-10)
    np.testing.assert_allclose(ship.attitude[1], 0.0, atol=1e-11)


@pytest.mark.slow
def test_a_ramp_starts_a_run_as_the_scene_at_rest(tmp_path, at_rest):
    (place, speed, tension), _, _ = seen(tmp_path, RAMPED, LASTS)
    np.testing.assert_allclose(place, at_rest[0][0], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(speed, 0.0)
    np.testing.assert_allclose(tension, at_rest[0][2], rtol=1e-9)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(
            'position = ["140 m", 0, "-5 m"], velocity = ["1 m/s", 0, "1 m/s"],'
            ' amplitude = [0, 0, "2 m"], period = "9 s", phase = 1',
            id="a steady velocity and an oscillation",
        ),
        # a record has no mean place: where it is at t = 0
        pytest.param(
            'time = [0, 1], position = [["140 m", 0, "-5 m"], ["141 m", 0, "-3 m"]]',
            id="a record",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_an_end_that_is_moved_rests_too(tmp_path, at_rest, path):
    (place, speed, tension), numbers, _ = seen(tmp_path, STILL, end=f"{{ motion = {{ {path} }} }}")
    np.testing.assert_allclose(place, at_rest[0][0], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(speed, 0.0)
    np.testing.assert_allclose(tension, at_rest[0][2], rtol=1e-9)
    assert numbers["end_tension"] == pytest.approx(at_rest[1]["end_tension"], rel=1e-9)


@pytest.mark.slow
def test_a_body_that_is_let_go_with_a_velocity_rests_too(tmp_path):
    def free(speed):
        body = (
            f'velocity = [{speed}, 0, 0]\nmass = "9 t"\n'
            'inertia = ["1 t m2", "1 t m2", "1 t m2"]\npoints'
        )
        text = MOORED.replace("motion = MOTION\n", "").replace("points", body, 1)
        text = text.replace('[sea]\nheight = "4 m"\nperiod = "10 s"\n', "")
        (tmp_path / "scene.toml").write_text(text.replace("END", SHIP).replace("TIMES", ""))
        run_study(load_study(tmp_path / "scene.toml"), tmp_path / "r.h5")
        with open_result(tmp_path / "r.h5") as result:
            assert not np.any(result.body("ship", "velocity", 0))
            return result.line("leg").field("tension")[0, 0]

    np.testing.assert_array_equal(free(1.0), free(0.0))


@pytest.mark.parametrize("times", ["", LASTS], ids=["at rest", "a run"])
@pytest.mark.slow
def test_pictures_have_the_ship_where_the_line_ends(tmp_path, times):
    study = scene_of(tmp_path, RAO, times)
    line = Resting(study).solve({}).lines["leg"].position[-1]
    ship = moved_ships(study.scene, np.zeros(1))["ship"]
    pitch = ship.attitude[0, 1]
    x, z = ship.position[0, 0], ship.position[0, 2]
    expected = [
        x - 20.0 * np.cos(pitch) - 5.0 * np.sin(pitch), z + 20.0 * np.sin(pitch) - 5.0 * np.cos(pitch)
    ]  # fmt: skip
    np.testing.assert_allclose(line[[0, 2]], expected, rtol=0, atol=1e-9)
    assert (abs(x - 160.0) > 0.1) == bool(times)


HAULED = """\
gravity = "9.81 m/s2"

[materials.wire]
law = "linear"
EA = "1 MN"
damping = "10 kN s"

[lines.highline]
MODEL
material = "wire"
length = "60 m"
segments = 12
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = ["60 m", 0, 0], tension = "10 kN" } }

[bodies.cargo]
mass = "100 kg"
on = { line = "highline", place = "20 m"SPEED }

[output]
"""


@pytest.mark.parametrize(
    "model",
    [pytest.param("", marks=pytest.mark.slow), 'model = "ideal"'],
    ids=["lumped", "ideal"],
)
def test_cargo_that_would_be_hauled_rests_too(tmp_path, model):
    def found(speed):
        text = HAULED.replace("MODEL", model).replace("SPEED", speed)
        (tmp_path / "scene.toml").write_text(text)
        (outcome,) = run_study(load_study(tmp_path / "scene.toml"), tmp_path / "r.h5")
        assert outcome.status.name == "OK"
        with open_result(tmp_path / "r.h5") as result:
            assert not np.any(result.body("cargo", "velocity", 0))
            return result.body("cargo", "position", 0)[0]

    place = found(', speed = "1 m/s", stop = "2 m"')
    assert place[0] == pytest.approx(20.0)
    np.testing.assert_allclose(place, found(""), rtol=0, atol=1e-9)
