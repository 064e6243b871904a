"""Ships in the scene language: what reads well, and what is wrong with what does not."""

import numpy as np
import pytest

from lumpedcable.scene import SceneError, load_study

SHIPS = """\
gravity = "9.81 m/s2"

[sea]
height = "2 m"
period = "8 s"

[materials.wire]
law = "linear"
EA = "57 MN"

[bodies.supply]
position = [0, 0, "1 m"]
motion.heave = { amplitude = "1 m", period = "8 s" }
motion.roll = { amplitude = "5 deg", period = "10 s" }
points = { post = [0, "5 m", "12 m"] }

[bodies.receiver]
position = [0, "60 m", 0]
motion = { file = "ship.csv" }
points = { post = [0, "-5 m", "10 m"] }

[bodies.third]
position = [0, "90 m", 0]
motion = { rao = "rao.csv" }
points = { bow = [0, 0, 0] }

[lines.highline]
material = "wire"
length = "53 m"
segments = 20
mass = "3 kg/m"
start = "supply.post"
end = "receiver.post"

[output]
duration = "2 s"
every = "0.1 s"
"""
RECORD = "t,heave,roll\n0,0,0\n1,0.5,0.01\n2,0.1,0.02\n"
RAO = "omega,heave,heave_phase\n0.4,1,0\n0.8,0.5,0.3\n"


def study(folder, *edits, record=RECORD, rao=RAO):
    text = SHIPS
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "scene.toml").write_text(text)
    (folder / "ship.csv").write_text(record)
    (folder / "rao.csv").write_text(rao)
    rows = {"path": (0, 0.5, 1, 1.5), "torn": (0, 0.1, 0.2, 0.3, 0.4, 0.5, 2.5)}
    for name, times in rows.items():
        text = "".join(f"{t},0,5,{13 + 0.1 * t}\n" for t in times)
        (folder / f"{name}.csv").write_text(f"t,x,y,z\n{text}")
    return load_study(folder / "scene.toml")


def test_ships_are_read_in_si(tmp_path):
    found = study(tmp_path)
    supply, receiver, third = found.scene.bodies.values()
    assert supply.motion.roll.amplitude == pytest.approx(np.deg2rad(5.0))
    assert supply.points["post"] == (0.0, 5.0, 12.0)
    assert receiver.motion.heave == (0.0, 0.5, 0.1)
    assert receiver.motion.names() == ("heave", "roll")
    assert third.motion.response == {"heave": ((1.0, 0.0), (0.5, 0.3))}
    numbers = found.scene.numbers()
    assert numbers["bodies.supply.motion.heave.period"] == 8.0
    assert not any(key.startswith("bodies.receiver.motion") for key in numbers)


def test_the_record_of_a_run_stands_alone(tmp_path):
    found = study(tmp_path)
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "scene.toml").write_text(found.effective_text)
    again = load_study(tmp_path / "copy" / "scene.toml").scene
    assert again.bodies["receiver"].motion.heave == (0.0, 0.5, 0.1)
    assert again.bodies["third"].motion.response == {"heave": ((1.0, 0.0), (0.5, 0.3))}


def test_a_motion_in_waves_may_grow(tmp_path):
    plain = study(tmp_path).scene
    grown = study(tmp_path, ('{ rao = "rao.csv" }', '{ rao = "rao.csv", ramp = "20 s" }'))
    assert plain.bodies["third"].motion.ramp is None
    assert grown.scene.bodies["third"].motion.ramp == 20.0
    assert grown.scene.numbers()["bodies.third.motion.ramp"] == 20.0
    assert grown.scene.skeleton() != plain.skeleton()
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "scene.toml").write_text(grown.effective_text)
    again = load_study(tmp_path / "copy" / "scene.toml").scene
    assert again.bodies["third"].motion.ramp == 20.0


def test_other_columns_of_a_record_are_left_alone(tmp_path):
    record = "t,heave,roll_rate,sway speed,yawing\n0,0,5,5,5\n2,0.1,5,5,5\n"
    assert study(tmp_path, record=record).scene.bodies["receiver"].motion.names() == ("heave",)


def test_a_record_may_rest_before_and_after(tmp_path):
    record = "t,heave,roll\n0.5,0,0\n0.6,0,0\n1,0.5,0.01\n1.2,0.1,0.02\n1.3,0.1,0.02\n"
    assert study(tmp_path, record=record).scene.bodies["receiver"].motion.time[-1] == 1.3


def test_another_record_is_another_structure(tmp_path):
    bones = study(tmp_path).scene.skeleton()
    assert study(tmp_path, record=RECORD.replace("0.5", "0.6")).scene.skeleton() != bones
    assert study(tmp_path, ('"1 m", period', '"2 m", period')).scene.skeleton() == bones


@pytest.mark.parametrize(
    ("edits", "files", "key", "words"),
    [
        ([('start = "supply.post"', 'start = "supply.pots"')], {}, "lines.highline.start",
         'expected a point of the moved body "supply", found "supply.pots"; did you mean "supply.post"'),
        ([('start = "supply.post"', 'start = "supply"')], {}, "lines.highline.start",
         "expected a point of the moved body"),
        ([("motion.roll = {", "motion.rol = {")], {}, "bodies.supply.motion.rol", 'did you mean "roll"'),
        ([('"5 deg"', '"5 m"')], {}, "bodies.supply.motion.roll.amplitude", "expected an angle (rad)"),
        ([("motion = { file", "motion = { fiel")], {}, "bodies.receiver.motion", 'did you mean "file"'),
        ([('[sea]\nheight = "2 m"\nperiod = "8 s"\n', "")], {}, "bodies.third.motion.rao",
         "expected [sea] for a motion in waves, found none"),
        ([], {"record": "t,heave\n0,0\n1,\n2,1\n"}, "bodies.receiver.motion.file",
         "expected a finite number in column heave, found nothing in ship.csv:3"),
        ([], {"record": "t,heave\n" + "".join(f"{t},0\n" for t in (0, 1, 2, 3, 20, 21))},
         "bodies.receiver.motion.file",
         "expected a record without gaps, a value about every 1 s, found none between 3 s and 20 s"),
        ([], {"record": "t,heave\n0,0\n1,0\n1,0\n"}, "bodies.receiver.motion.file",
         "expected times that increase"),
        ([('duration = "2 s"', 'duration = "3 s"')], {}, "bodies.receiver.motion.file",
         "expected a record until the run ends at 3 s, or one that ends at rest, found its last time "
         "at 2 s"),
        ([], {"record": "t,heave\n1,0\n2,0.1\n3,0\n"}, "bodies.receiver.motion.file",
         "expected a record from 0 s on, or one that begins at rest, found its first time at 1 s"),
        ([('start = "supply.post"', 'start = { motion = { file = "path.csv" } }')], {},
         "lines.highline.start.motion.file", "found its last time at 1.5 s"),
        ([('start = "supply.post"', 'start = { motion = { file = "torn.csv" } }')], {},
         "lines.highline.start.motion.file", "found none between 0.5 s and 2.5 s"),
        # its spline would go on at 1 s as it came, 16 times as far as it ever is
        ([('start = "supply.post"', 'start = { motion = { time = [0, 0.5, 1, 100], position = '
           "[[0, 0, 0], [0, 0, 0.01], [0, 0, 0.02], [0, 0, 0.02]] } }")], {},
         "lines.highline.start.motion.time",
         "a value about every 0.5 s, found none between 1 s and 100 s"),
        ([], {"record": "t,x,y\n0,0,0\n"}, "bodies.receiver.motion.file",
         "expected the columns t and any of surge, sway, heave"),
        # beside one that is right it would be left out without a word
        ([], {"record": "t,Surge (m),heave\n0,0,0\n1,1,1\n2,1,1\n"}, "bodies.receiver.motion.file",
         'expected the column "surge", found "Surge (m)" in ship.csv; rename it'),
        ([], {"record": "t,heave,roll_deg\n0,0,0\n1,1,1\n2,1,1\n"}, "bodies.receiver.motion.file",
         'expected the column "roll", found "roll_deg" in ship.csv; rename it'),
        ([], {"rao": RAO.replace("omega", "omega,PITCH").replace("\n0.", "\n0.1,0.")},
         "bodies.third.motion.rao", 'expected the column "pitch", found "PITCH" in rao.csv'),
        ([('{ rao = "rao.csv" }', '{ rao = "rao.csv", ramp = "20 m" }')], {}, "bodies.third.motion.ramp",
         'expected a positive time (s), found a length (m), "20 m"'),
        ([], {"rao": "omega,heave\n0.4,1\n"}, "bodies.third.motion.rao", "heave_phase"),
        ([], {"rao": RAO.replace("0.4", "0.3").replace("0.8", "0.7")}, "bodies.third.motion.rao",
         "expected frequencies about 0.785 rad/s, where the waves peak, found 0.3 to 0.7 rad/s"),
        ([("[materials.wire]", '[sweep]\n"sea.period" = ["8 s", "9 s", "20 s"]\n[materials.wire]')], {},
         "bodies.third.motion.rao", "about 0.314 rad/s, where the waves peak, found 0.4 to 0.8 rad/s"),
        ([], {"rao": RAO.replace("0.8", "0.3")}, "bodies.third.motion.rao",
         "expected frequencies that increase"),
        ([('position = [0, 0, "1 m"]\n', 'position = [0, 0, "1 m"]\nmass = 3\n')], {},
         "bodies.supply.mass", "mass"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_fault_where_it_is(tmp_path, edits, files, key, words):
    with pytest.raises(SceneError) as caught:
        study(tmp_path, *edits, **files)
    (fault,) = caught.value.faults
    assert fault.key == key
    assert words in fault.message


def test_what_pictures_alone_read_is_no_number_of_the_scene(tmp_path):
    size = ('points = { post = [0, "5 m"', 'size = ["90 m", 18, 22]\npoints = { post = [0, "5 m"')
    plain, drawn = study(tmp_path).scene, study(tmp_path, size).scene
    assert drawn.bodies["supply"].size == (90.0, 18.0, 22.0)
    assert drawn.numbers() == plain.numbers()
    assert drawn.skeleton() == plain.skeleton()  # so that no other program is compiled
    sweep = ("[output]", '[sweep]\n"bodies.supply.size.0" = [80, 90]\n\n[output]')
    with pytest.raises(
        SceneError, match=r'found "bodies.supply.size.0", which pictures alone read'
    ):
        study(tmp_path, size, sweep)


RIGID = (
    '[materials.hooke]\nlaw = "linear"\nEA = 1e6\n'
    "[lines.rope]\nmaterial = 'hooke'\nlength = 10\nsegments = 4\nmass = 1\n"
    "start = { fixed = [0, 0, 0] }\nend = 'ship'\n"
    "[bodies.ship]\nmass = 100\nposition = [10, 0, 0]\nsize = [2, 1, 1]\n"
)


@pytest.mark.parametrize(
    ("more", "key", "words"),
    [
        ("drag = [1, 1, 1]", "bodies.ship.drag", "expected [water] or [air] for drag, found neither"),
        ('free = ["x"]\ncontrol.force = [0, 1e9, 0]', "bodies.ship.control.force.1",
         'found 1e+09, without "y" in free'),
        ('free = ["x", "yaw"]\ncontrol.stiffness = [1, 2, 0]', "bodies.ship.control.stiffness.1",
         "expected 0 along a way that the body cannot move in, found 2"),
        ('free = ["x", "roll"]\ncontrol.turn_damping = [1, 0, 3]',
         "bodies.ship.control.turn_damping.2", 'without "yaw" in free'),
        ('free = ["x", "y"]\ncontrol.moment = [0, 0, 1e9]', "bodies.ship.control.moment",
         "expected a body that can turn"),
    ],
)  # fmt: skip
def test_what_would_do_nothing_is_refused(tmp_path, more, key, words):
    (tmp_path / "s.toml").write_text(f"{RIGID}{more}\n[output]\n")
    with pytest.raises(SceneError) as told:
        load_study(tmp_path / "s.toml")
    (fault,) = told.value.faults
    assert key in str(fault)
    assert words in str(fault)


@pytest.mark.parametrize(
    "more",
    [
        'free = ["x", "yaw"]\ncontrol.force = [0, 1e9, 0]',  # its own axes turn
        'free = ["x"]\nattitude = [0, 0, 1]\ncontrol.force = [0, 1e9, 0]',
        'free = ["x", "y"]\ncontrol = { force = [1, 2, 0], stiffness = [1, 2, 0] }',
    ],
)
def test_what_does_something_is_taken(tmp_path, more):
    (tmp_path / "s.toml").write_text(f"{RIGID}{more}\n[output]\n")
    assert load_study(tmp_path / "s.toml").scene.bodies["ship"].rigid


def test_a_heading_that_begins_anew_is_no_turn(tmp_path):
    """A record of 178, 179, -180 degrees turned the ship once round in a second."""
    wraps = "t,yaw (deg)\n0,178\n1,179\n2,-180\n3,-179\n"
    with pytest.raises(SceneError) as told:
        study(tmp_path, record=wraps)
    words = (
        "expected yaw that goes on beyond half a turn, 180 deg at 2 s, found -180 deg after 179 deg"
    )
    assert words in str(told.value)
    goes_on = study(tmp_path, record=wraps.replace("-180", "180").replace("-179", "181"))
    assert goes_on.scene.bodies["receiver"].motion.yaw[-1] == pytest.approx(np.radians(181.0))
