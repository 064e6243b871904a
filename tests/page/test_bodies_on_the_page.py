"""Bodies on the page: where they are, how they are turned, how large they are."""

import numpy as np
import pytest
from page.test_recorded_page import unpacked

from lumpedcable.page.bodies import quaternion
from lumpedcable.page.recorded import recorded
from lumpedcable.page.surroundings import surroundings
from lumpedcable.results import Coordinate, ResultWriter, Variable

TIMES = np.linspace(0.0, 4.0, 5)
SCENE = """
[water]
density = 1025.0
[bodies.ship]
mass = 1.0
size = [20.0, 8.0, 4.0]
hull = { surface = 1.5 }
[bodies.buoy]
mass = 2.0
[lines.rope]
start = "ship.bow"
end = "buoy"
"""


def turned(q, v):
    """v turned by the unit quaternion q = (w, u): v + 2 u x (u x v + w v)."""
    w, u = q[0], q[1:]
    return v + 2.0 * np.cross(u, np.cross(u, v) + w * v)


def test_a_turn_is_roll_then_pitch_then_yaw():
    roll, pitch, yaw = 0.3, -0.5, 1.1
    c, s = np.cos, np.sin
    x = np.array([[1, 0, 0], [0, c(roll), -s(roll)], [0, s(roll), c(roll)]])
    y = np.array([[c(pitch), 0, s(pitch)], [0, 1, 0], [-s(pitch), 0, c(pitch)]])
    z = np.array([[c(yaw), -s(yaw), 0], [s(yaw), c(yaw), 0], [0, 0, 1]])
    q = quaternion([roll, pitch, yaw])
    for v in np.eye(3):
        assert turned(q, v) == pytest.approx(z @ y @ x @ v, abs=1e-12)
    assert np.isnan(quaternion([np.nan, 0.0, 0.0])).all()


@pytest.fixture
def file(tmp_path):
    """A ship that moves along x and pitches through more than half a turn."""
    path = tmp_path / "r.h5"
    nodes = np.zeros((1, 5, 2, 3))
    nodes[..., 1, 0] = 10.0
    place = np.stack([TIMES, 0 * TIMES, 2.0 + 0 * TIMES], axis=-1)[None]
    attitude = np.stack([0 * TIMES, 0.9 * TIMES, 0 * TIMES], axis=-1)[None]
    dims = {"run": 1, "time": 5, "xyz": 3, "angle": 3,
            "lines/rope/node": 2, "lines/rope/segment": 1}  # fmt: skip
    variables = [
        Variable("lines/rope/position", ("run", "time", "node", "xyz"), "f8", "m"),
        Variable("bodies/ship/position", ("run", "time", "xyz"), "f8", "m"),
        Variable("bodies/ship/attitude", ("run", "time", "angle"), "f8", "rad"),
    ]
    coordinates = {
        "time": Coordinate(TIMES, "s"),
        "lines/rope/unstretched_position": Coordinate([0.0, 10.0], "m", "", ("node",)),
        "lines/rope/unstretched_segment": Coordinate([5.0], "m", "", ("segment",)),
    }
    with ResultWriter(path, dims=dims, variables=variables, coordinates=coordinates,
                      attributes={"scene": SCENE}) as writer:  # fmt: skip
        writer.write("lines/rope/position", nodes)
        writer.write("bodies/ship/position", place)
        writer.write("bodies/ship/attitude", attitude)
        writer.finish()
    return path


def test_a_body_is_where_the_file_says(file):
    head = recorded(file)
    block = head.pack.text()
    (ship,) = head["bodies"]
    assert (ship["name"], ship["size"]) == ("ship", [20.0, 8.0, 4.0])
    x = unpacked(block, ship["position"][0])
    assert x == pytest.approx(TIMES[None], abs=1e-4)
    q = np.stack([unpacked(block, part)[0] for part in ship["attitude"]], axis=-1)
    for k, time in enumerate(TIMES):
        # pitch turns x down
        right = [np.cos(0.9 * time), 0, -np.sin(0.9 * time)]
        assert turned(q[k], np.array([1.0, 0, 0])) == pytest.approx(right, abs=1e-3)
    # neighbours can be mixed without a flip
    assert (np.sum(q[1:] * q[:-1], axis=-1) > 0).all()


def test_it_is_read_out_as_far_as_it_moves(file):
    head = recorded(file)
    block = head.pack.text()
    rows = {h["key"]: h for h in head["histories"] if h["group"] == "ship"}
    # it moves along x, stays at z = 2 m, pitches; y, roll and yaw are nothing
    assert list(rows) == [f"bodies/ship/{k}" for k in ("position/0", "position/2", "attitude/1")]
    pitch = rows["bodies/ship/attitude/1"]
    assert pitch["unit"] == "deg"
    assert unpacked(block, pitch["data"])[0] == pytest.approx(np.degrees(0.9 * TIMES), rel=1e-6)


def test_a_point_is_at_its_line_and_a_hull_tells_of_the_surface(file):
    head = recorded(file)
    assert head["surroundings"]["points"] == [
        {"name": "buoy", "mass": 2.0, "line": "rope", "at_end": True}
    ]
    assert head["surroundings"]["surface"] == 1.5
    floats = {"water": {}, "bodies": {"ship": {"hull": {}}}}
    assert surroundings(floats)["surface"] == 0.0
