"""Bodies on the page: where they are, how they are turned, how large they are."""

import numpy as np
import pytest
from command_line import say
from page.test_recorded_page import unpacked

from lumpedcable.page.bodies import quaternion
from lumpedcable.page.filmed import beside_lines
from lumpedcable.page.recorded import recorded
from lumpedcable.page.surroundings import surroundings
from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.results.sound import SoundFile
from lumpedcable.study.moved import Moved, straight_lines, study_of_text
from lumpedcable.view import animation, style

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
    assert (ship["name"], ship["size"]) == ("ship", [[20.0, 8.0, 4.0]])
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
    assert list(rows) == [
        f"bodies/ship/{k}" for k in ("position/x", "position/z", "attitude/pitch")
    ]
    pitch = rows["bodies/ship/attitude/pitch"]
    assert pitch["unit"] == "deg"
    assert unpacked(block, pitch["data"])[0] == pytest.approx(np.degrees(0.9 * TIMES), rel=1e-6)


def test_a_point_is_at_its_line_and_a_hull_tells_of_the_surface(file):
    head = recorded(file)
    assert head["surroundings"][0]["points"] == [
        {"name": "buoy", "mass": 2.0, "line": "rope", "at_end": True}
    ]
    assert head["surroundings"][0]["surface"] == 1.5
    floats = {"water": {}, "bodies": {"ship": {"hull": {}}}}
    assert surroundings(floats)["surface"] == 0.0


def test_a_point_mass_is_filmed_at_the_end_of_its_line(tmp_path):
    # one run has a node less than the other, which reads NaN; the rope parts, and what holds on is last
    scene = """
[bodies.buoy]
mass = 2.0
[lines.rope]
start = "free"
end = "buoy"
[lines.leader]
start = "buoy"
end = "free"
[events.break]
breaks = "leader.start"
"""
    path = tmp_path / "r.h5"
    place = np.cumsum(np.ones((2, 5, 3, 3)), axis=2) + TIMES[:, None, None]
    place[1, :, 2] = np.nan
    dims = {"run": 2, "time": 5, "xyz": 3}
    known, variables = {"time": Coordinate(TIMES, "s")}, []
    for name in ("leader", "rope-1", "rope-2"):
        dims |= {f"lines/{name}/node": 3, f"lines/{name}/segment": 2}
        group = f"lines/{name}"
        nodes, middles = [[0.0, 1.0, 2.0], [0.0, 1.0, np.nan]], [[0.5, 1.5], [0.5, np.nan]]
        known[f"{group}/unstretched_position"] = Coordinate(nodes, "m", "", ("run", "node"))
        known[f"{group}/unstretched_segment"] = Coordinate(middles, "m", "", ("run", "segment"))
        variables.append(Variable(f"{group}/position", ("run", "time", "node", "xyz"), "f8", "m"))
        variables.append(Variable(f"{group}/tension", ("run", "time", "segment"), "f8", "N"))
    told = {"effective_scene": scene}
    with ResultWriter(
        path, dims=dims, variables=variables, coordinates=known, attributes=told
    ) as writer:
        for k, name in enumerate(("leader", "rope-1", "rope-2")):
            writer.write(f"lines/{name}/position", place + 10.0 * k)
            writer.write(f"lines/{name}/tension", np.ones((2, 5, 2)))
        writer.finish()
    assert [p["line"] for p in recorded(path)["surroundings"][0]["points"]] == ["rope-2"]
    with SoundFile.open(path) as result, style.styled():
        for run, last in ((0, 2), (1, 1)):
            film = animation._Film(result, run, 1.0, beside_lines(result, run))
            film.show(3)
            seen = np.array(film.marks.get_data())[:, 0]
            right = place[run, 3, last] + 20.0
            np.testing.assert_allclose(seen, right[[film.across, film.up]])


TRANSFER = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = 1e7
[bodies.ship]
position = [0.0, 0.0, 1.0]
points = { post = [0.0, 0.0, 15.0] }
size = [40.0, 12.0, 8.0]
motion = { heave = { amplitude = 2.0, period = 8.0 }, roll = { amplitude = 0.1, period = 5.0 } }
[bodies.cargo]
mass = 2000.0
depth = 3.0
inertia = 500.0
size = [2.0, 2.0, 1.0]
on = { line = "highline", place = 10.0 }
[lines.highline]
model = "ideal"
material = "wire"
length = 50.0
segments = 10
mass = 3.0
start = "ship.post"
end = { winch = { at = [0.0, 50.0, 14.0], tension = 80e3 } }
[output]
duration = 4.0
every = 1.0
"""


@pytest.fixture
def transfer(tmp_path):
    return transfer_file(tmp_path, TRANSFER)


def transfer_file(folder, scene):
    """The file of a scene whose only records are the trolley's place and how the cargo swings."""
    path = folder / "t.h5"
    place = np.stack([0 * TIMES, 10.0 + TIMES, 14.0 + 0 * TIMES], axis=-1)[None]
    attitude = np.stack([0.2 * TIMES, 0 * TIMES, 0 * TIMES], axis=-1)[None]
    dims = {"run": 1, "time": 5, "xyz": 3, "angle": 3}
    variables = [
        Variable("bodies/cargo/position", ("run", "time", "xyz"), "f8", "m"),
        Variable("bodies/cargo/attitude", ("run", "time", "angle"), "f8", "rad"),
    ]
    told = {"effective_scene": scene}
    when = {"time": Coordinate(TIMES, "s")}
    with ResultWriter(
        path, dims=dims, variables=variables, coordinates=when, attributes=told
    ) as writer:
        writer.write("bodies/cargo/position", place)
        writer.write("bodies/cargo/attitude", attitude)
        writer.finish()
    return path


def test_ships_that_are_moved_and_ideal_cables_are_worked_out(transfer):
    head = recorded(transfer)
    block = head.pack.text()

    def way(thing):
        return np.stack([unpacked(block, part)[0] for part in thing["position"]], axis=-1)

    bodies = {body["name"]: body for body in head["bodies"]}
    heave = 2.0 * np.sin(2.0 * np.pi * TIMES / 8.0)
    roll = 0.1 * np.sin(2.0 * np.pi * TIMES / 5.0)
    still = 0 * TIMES
    ship = bodies["ship"]
    assert way(ship) == pytest.approx(np.stack([still, still, 1.0 + heave], axis=-1), abs=1e-3)
    q = np.stack([unpacked(block, part)[0] for part in ship["attitude"]], axis=-1)
    assert 2.0 * np.arcsin(q[:, 1]) == pytest.approx(roll, abs=1e-3)
    assert (ship["size"], ship["points"]) == ([[40.0, 12.0, 8.0]], [[[0.0, 0.0, 15.0]]])
    # a roll tips the post towards -y; the cable is straight from it to the trolley and the winch
    (line,) = head["lines"]
    post = np.stack([still, -15.0 * np.sin(roll), 1.0 + heave + 15.0 * np.cos(roll)], axis=-1)
    trolley = np.stack([still, 10.0 + TIMES, 14.0 + still], axis=-1)
    assert way(line)[:, 0] == pytest.approx(post, abs=1e-3)
    assert way(line)[:, 1] == pytest.approx(trolley, abs=1e-3)
    assert way(line)[:, 2] == pytest.approx(np.tile([0.0, 50.0, 14.0], (5, 1)), abs=1e-3)
    assert unpacked(block, line["tension"]) == pytest.approx(80e3)
    # cargo swings under its trolley: turned about x, down goes to +y
    below = np.stack([still, 3.0 * np.sin(0.2 * TIMES), -3.0 * np.cos(0.2 * TIMES)], axis=-1)
    assert way(bodies["cargo"]) == pytest.approx(trolley + below, abs=1e-3)
    assert way(bodies["trolley of cargo"]) == pytest.approx(trolley, abs=1e-3)
    lengths = {h["key"]: h for h in head["histories"]}["lines/highline/length"]
    whole = np.linalg.norm(post - trolley, axis=1) + np.hypot(40.0 - TIMES, 0.0)
    assert unpacked(block, lengths["data"])[0] == pytest.approx(whole, rel=1e-6)


def test_an_ideal_cable_goes_with_the_free_ship_that_its_post_stands_on():
    lines = ["mass = 4e5" if line.startswith("motion") else line for line in TRANSFER.splitlines()]
    scene = study_of_text("\n".join(lines)).scene
    still = 0 * TIMES
    place = np.stack([still, 0.5 * TIMES, 1.0 + still], axis=-1)
    roll = 0.1 * TIMES
    ships = {"ship": Moved(place, np.stack([roll, still, still], axis=-1))}
    riders = {"cargo": np.stack([still, 10.0 + still, 14.0 + still], axis=-1)}
    line = straight_lines(scene, ships, riders, TIMES)["highline"]
    post = place + np.stack([still, -15.0 * np.sin(roll), 15.0 * np.cos(roll)], axis=-1)
    assert line.position[:, 0] == pytest.approx(post)


def test_ideal_cables_ships_and_cargo_are_filmed(transfer):
    said = say(transfer.parent, "animate", transfer.name, "--seconds", "0.4", "--fps", "5")
    assert (said.code, said.out, said.err) == (0, "t.gif\n", "")
    with SoundFile.open(transfer) as result, style.styled():
        film = animation._Film(result, 0, 1.0, beside_lines(result, 0))
        film.show(4)
        (y, z), (first, last) = film.shapes[0].get_segments()[0][1], film.limits
        assert (y, z) == pytest.approx((10.0 + TIMES[4], 14.0), abs=1e-6)  # the trolley
        assert film.curves[0].get_ydata() == pytest.approx(80.0)
        assert first <= 0.0 < 80.0 <= last
        # the section of a ship of 12 m by 8 m that heaves and rolls, and a post of 15 m on its middle
        cargo, ship = film.solids
        faces = np.array([path.vertices[:4] for path in ship.get_paths()])
        heave, roll = 1.0 + 2.0 * np.sin(np.pi), 0.1 * np.sin(1.6 * np.pi)
        turn = np.array([[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]])
        corners = [turn @ [6.0 * a, 4.0 * b] + [0.0, heave] for a in (-1, 1) for b in (-1, 1)]
        assert len(faces) == 7
        for face in faces[:6]:
            for corner in face:
                assert np.abs(corner - corners).max(axis=1).min() < 1e-9
        for corner in corners:
            assert np.abs(faces[:6] - corner).max(axis=2).min() < 1e-9
        ends = [turn @ [0.0, up] + [0.0, heave] for up in (4.0, 15.0)]
        assert faces[6] == pytest.approx(np.array([ends[0], ends[1], ends[1], ends[0]]))
        # the trolley is a ball; cargo swings 3 m under it
        assert film.marks.get_xydata() == pytest.approx(np.array([(14.0, 14.0)]))
        middle = np.mean([path.vertices[:4] for path in cargo.get_paths()], axis=(0, 1))
        assert middle == pytest.approx([14.0 + 3.0 * np.sin(0.8), 14.0 - 3.0 * np.cos(0.8)])
