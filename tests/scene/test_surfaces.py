"""The surface of the water in a scene: what goes with it and what does not."""

import pytest

from lumpedcable.scene import SceneError, load_study

SCENE = """\
gravity = "9.81 m/s2"

[water]
density = "1025 kg/m3"
surface = 0

[materials.wire]
law = "linear"
EA = "10 MN"

[lines.rope]
material = "wire"
length = "60 m"
segments = 10
mass = "5 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, 5] }
end = "buoy"

[bodies.buoy]
mass = 100

[output]
duration = 1
every = 0.1
"""
FLOW = "[sea]\nheight = 1\nperiod = 6\nflow = {}\n"


def faults(folder, *edits, sets=()):
    text = SCENE
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    (folder / "scene.toml").write_text(text)
    try:
        load_study(folder / "scene.toml", sets)
    except SceneError as error:
        return [f"{fault.key}: {fault.message}" for fault in error.faults]
    return []


VOLUME = ("mass = 100", "mass = 100\nvolume = 1")
BED = "[seabed]\nheight = -40\nstiffness = 1e6\n"
SLOPE = "[seabed.profile]\nx = [0, 100]\ndepth = [0, 30]\n"


def waves_over(bed, depth):
    """The edit that brings waves on water of a depth (m) over a bed."""
    return [("[output]", FLOW.replace("flow", f"depth = {depth}\nflow") + bed + "[output]")]


@pytest.mark.parametrize(
    ("edits", "told"),
    [
        ([], None),
        ([VOLUME], None),
        ([VOLUME, ("[output]", FLOW + "[output]")], "bodies.buoy.volume: expected a rigid body"),
        (
            [VOLUME, ("volume = 1", 'volume = 1\nposition = [1, 0, 0]\nfree = ["z"]'),
             ('end = "buoy"', 'end = "free"'), ("[output]", FLOW + "[output]")],
            None,
        ),
        ([('gravity = "9.81 m/s2"\n', "")], "water.surface: expected gravity"),
        ([("[water]", "[air]")], "air.surface: expected no surface of the air, found one"),
        (
            [('law = "linear"\nEA = "10 MN"', 'law = "inextensible"')],
            "lines.rope.material: expected an elastic material",
        ),
        (
            [("[output]", FLOW.replace("flow = {}", "flow = { surface = 1 }") + "[output]")],
            "sea.flow.surface: expected 0 m, the height of the water's surface in water.surface",
        ),
        (
            [('end = "buoy"', 'end = "free"'),
             ("mass = 100", "mass = 100\nsize = [1, 1, 1]\nposition = [9, 0, 0]\ndrag = [1, 1, 1]")],
            "bodies.buoy.volume: expected the volume (m3) of a body with drag",
        ),
        (waves_over(BED, 40), None),
        (waves_over(BED, 37), None),
        (
            waves_over(BED, 30),
            "sea.depth: expected the depth of the water over the seabed, 40 m (its surface is at 0 m), "
            "found 30 m",
        ),
        (waves_over(BED + SLOPE, 40), None),
        (waves_over(BED + SLOPE, 60), None),
        (
            waves_over(BED + SLOPE, 90),
            "sea.depth: expected the depth of the water over the seabed, 40 m to 70 m",
        ),
        (
            [("surface = 0\n", ""), *waves_over(BED, 30)],
            "sea.depth: expected the depth of the water over the seabed, 40 m (its surface is at 0 m)",
        ),
        (
            [*waves_over("", 40), ("period = 6", 'period = 6\ndirection = 30')],
            "sea.direction: expected an angle of at most a turn (6.28 rad, 360 deg) either way, found "
            "30 rad; a number without a unit is in rad",
        ),
        ([*waves_over("", 40), ("period = 6", 'period = 6\ndirection = "-360 deg"')], None),
        (
            [("mass = 100", "mass = 100\nvolume = 1\nsize = [1, 1, 1]\nposition = [9, 0, 0]"),
             ("volume = 1", "volume = 1\nattitude = [0, 0, 30]"), ('end = "buoy"', 'end = "free"')],
            "bodies.buoy.attitude.2: expected an angle of at most a turn",
        ),
    ],
)  # fmt: skip
def test_what_goes_with_a_surface(tmp_path, edits, told):
    found = faults(tmp_path, *edits)
    if told is None:
        assert found == []
    else:
        assert any(message.startswith(told) for message in found), found


def test_its_height_is_a_number_that_a_sweep_changes(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE + '[sweep]\n"water.surface" = ["-1 m", "2 m"]\n')
    study = load_study(tmp_path / "scene.toml")
    assert [scene.sea_level for scene in study.runs] == [-1.0, 2.0]
