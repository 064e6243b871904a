"""Angles in degrees that stand without their unit are told, wherever angles stand."""

import math

import pytest

from lumpedcable.scene import SceneError, load_study

SHIP = """\
gravity = 9.81

[materials.wire]
law = "linear"
EA = "1 MN"

[lines.stay]
material = "wire"
length = 10
segments = 4
mass = 1
start = { motion = { position = [0, 0, 0], amplitude = [0, 0, 1], period = 8, phase = PHASE } }
end = "ship.post"

[bodies.ship]
position = [9, 0, 0]
points = { post = [0, 0, 0] }
motion = MOTION

[sea]
height = 1
period = 8

[output]
duration = 1
every = 0.5
"""
STILL = "{ heave = { amplitude = 1, period = 8 } }"
IN_RAD = "a number without a unit is in rad"


def faults(folder, phase="0", motion=STILL):
    (folder / "scene.toml").write_text(SHIP.replace("PHASE", phase).replace("MOTION", motion))
    try:
        load_study(folder / "scene.toml")
    except SceneError as error:
        return [(fault.key, fault.message) for fault in error.faults]
    return []


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"phase": "90"}, "lines.stay.start.motion.phase"),
        ({"motion": "{ heave = { amplitude = 1, period = 8, phase = -90 } }"},
         "bodies.ship.motion.heave.phase"),
        ({"motion": "{ roll = { amplitude = 10, period = 8 } }"}, "bodies.ship.motion.roll.amplitude"),
    ],
)  # fmt: skip
def test_phases_and_swings_of_more_than_a_turn(tmp_path, change, key):
    ((told, message),) = faults(tmp_path, **change)
    assert told == key
    assert message.endswith(IN_RAD)


@pytest.mark.parametrize("phase", ["6.2", '"90 deg"', '"-360 deg"'])
def test_phases_within_a_turn_are_right(tmp_path, phase):
    assert faults(tmp_path, phase=phase) == []


@pytest.mark.parametrize(
    ("head", "phases", "wrong"),
    [
        ("heave_phase", [0, -20, -95, -178], True),
        ("heave_phase (deg)", [0, -20, -95, -178], False),
        ("heave_phase (deg)", [0, 170, -170, -20], False),  # it begins anew
        ("heave_phase", [0, 3.1, -3.1, -0.3], False),
        ("heave_phase", [-4, -6, -7, -8], False),  # it goes on
    ],
)
def test_phases_of_a_table_leap(tmp_path, head, phases, wrong):
    rows = [f"{0.6 + 0.2 * k},1,{phase}\n" for k, phase in enumerate(phases)]
    (tmp_path / "rao.csv").write_text(f"omega,heave,{head}\n" + "".join(rows))
    told = faults(tmp_path, motion='{ rao = "rao.csv" }')
    assert bool(told) is wrong
    if wrong:
        assert told[0][1].endswith(f'{IN_RAD}: write "heave_phase (deg)"')


@pytest.mark.parametrize(
    ("angles", "words"),
    [
        ([0, 5, 10, 15], IN_RAD),
        ([3.0, 3.1, -3.1, -3.0], "goes on beyond half a turn"),
        ([0, 0.1, 0.2, 0.1], None),
    ],
)
def test_angles_of_a_record(tmp_path, angles, words):
    told = faults(tmp_path, motion=f"{{ time = [0, 0.5, 1, 1.5], yaw = {angles} }}")
    assert (words is None) is (told == [])
    if words:
        assert words in told[0][1]


@pytest.mark.parametrize(("wrap", "right"), [(math.pi, True), (25.0, True), (90, False)])
def test_a_line_goes_around_a_drum_a_few_times(tmp_path, wrap, right):
    sheave = f"sheave = {{ friction = 0.1, wrap = {wrap} }}"
    winch = f"{{ winch = {{ at = [9, 0, 0], tension = 1000, {sheave} }} }}"
    text = SHIP.replace("PHASE", "0").replace("MOTION", STILL).replace('"ship.post"', winch)
    (tmp_path / "scene.toml").write_text(text)
    try:
        load_study(tmp_path / "scene.toml")
        told = []
    except SceneError as error:
        told = [fault.message for fault in error.faults if fault.key.endswith("wrap")]
    assert (told == []) is right
    assert all("5 turns (31.4 rad, 1800 deg)" in message for message in told)


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("material = wire", 'did you mean material = "wire"?'),
        ("tension_only = True", "did you mean tension_only = true?"),
        ("length = 10 m", 'did you mean length = "10 m"?'),
    ],
)
def test_values_that_are_no_toml_get_their_quotes(tmp_path, line, hint):
    (tmp_path / "scene.toml").write_text(f'title = "x"\n{line}\n')
    with pytest.raises(SceneError, match="expected TOML") as caught:
        load_study(tmp_path / "scene.toml")
    (fault,) = caught.value.faults
    assert fault.line == 2
    assert fault.message.endswith(hint)
