"""Joints of lines that bend: hinges are told, and rigid ones must be of two ends that can bend."""

import pytest
from engine_runs import line_text, scene_of

from lumpedcable.scene import SceneError
from lumpedcable.scene.idle import idle_parts

PIPES = """
[materials.steel]
law = "linear"
EA = "1 MN"

[output]
duration = "1 s"
every = "0.5 s"
"""
BENDS = 'bending = { EI = "300 N m2" }'
WALL = "{ fixed = [0, 0, 0] }"
CLAMP = "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"
HINGE = '"a.end"'
RIGID = '{ joined = "a.end", rigid = true }'


def pipes(start=HINGE, a=BENDS, b=BENDS, wall=CLAMP, end='"free"', more=""):
    first = line_text("a", "steel", 2, 4, 2, wall, end, a)
    return PIPES + first + line_text("b", "steel", 2, 4, 2, start, '"free"', b) + more


@pytest.mark.parametrize(
    ("start", "b", "said"), [(HINGE, BENDS, 1), (HINGE, "", 0), (RIGID, BENDS, 0)]
)
def test_a_joint_of_two_that_bend_is_a_hinge(tmp_path, start, b, said):
    words = list(idle_parts(scene_of(tmp_path, pipes(start, b=b))))
    assert len(words) == said
    assert all(w.startswith("lines.b.start is a hinge") for w in words)
    assert all('{ joined = "a.end", rigid = true }' in w for w in words)


@pytest.mark.parametrize(
    ("changes", "where", "said"),
    [
        ({"b": ""}, "lines.b.start.rigid", 'bending on both lines, found none on "b"'),
        (
            {"a": "", "wall": WALL},
            "lines.b.start.rigid",
            'bending on both lines, found none on "a"',
        ),
        (
            {"start": '{ joined = "a.start", rigid = true }'},
            "lines.b.start.rigid",
            'an end that is free to turn, found "a.start", which keeps a direction',
        ),
        (
            {"more": line_text("c", "steel", 2, 4, 2, RIGID, '"free"', BENDS)},
            "lines.c.start.rigid",
            'an end of one rigid joint, found "a.end", which has one with "b.start"',
        ),
        (
            {"end": '{ joined = "b.start", rigid = true }'},
            "lines.b.start.rigid",
            'an end of one rigid joint, found "b.start", which has one with "a.end"',
        ),
        (
            {"start": '{ joined = "c.end", rigid = true }'},
            "lines.b.start.joined",
            "the end of another line",
        ),
        ({"start": '{ joined = "a.end", stiff = true }'}, "lines.b.start.stiff", "rigid"),
    ],
)
def test_mistakes_of_rigid_joints_are_told(tmp_path, changes, where, said):
    with pytest.raises(SceneError) as told:
        scene_of(tmp_path, pipes(**{"start": RIGID, **changes}))
    lines = [line for line in str(told.value).splitlines() if where in line]
    assert any(said in line for line in lines), str(told.value)


@pytest.mark.parametrize("start", ['{ joined = "a.end" }', '{ joined = "a.end", rigid = false }'])
def test_a_joined_end_needs_no_place(tmp_path, start):
    assert scene_of(tmp_path, pipes(start)).lines["b"].start.at is None


SHIP = (
    "[bodies.ship]\nposition = [-5, 0, 0]\nmotion.heave = { amplitude = 1, period = 8 }\n"
    "points = { bow = [5, 0, 0] }\n"
    "[bodies.block]\nmass = 1\nposition = [0, 0, 0]\nfree = []\n"
    "[bodies.lump]\nmass = 1\n"
)


def tied(to, more=", direction = [1, 0, 0]"):
    return f'{{ tied = "{to}"{more} }}'


@pytest.mark.parametrize("to", ["ship.bow", "block"])
def test_lines_are_clamped_to_rigid_and_moved_bodies(tmp_path, to):
    assert scene_of(tmp_path, pipes(wall=tied(to), more=SHIP)).lines["a"].start.tied == to


@pytest.mark.parametrize(
    ("changes", "where", "said"),
    [
        ({"wall": tied("ship.bowl")}, "lines.a.start.tied", 'did you mean "ship.bow"'),
        ({"wall": tied("ship")}, "lines.a.start.tied", 'a point of the moved body "ship"'),
        ({"wall": tied("blok")}, "lines.a.start.tied", 'did you mean "block"'),
        ({"wall": tied("b.end")}, "lines.a.start.tied", "a body or a point of one"),
        ({"wall": tied("lump")}, "lines.a.start.tied", 'a rigid body, found "lump", a point mass'),
        ({"wall": tied("block", "")}, "lines.a.start.direction", "found nothing"),
        (
            {"wall": tied("block"), "a": ""},
            "lines.a.start.direction",
            "expected bending on a line whose end keeps a direction, found none",
        ),
        (
            {"wall": tied("block"), "more": '[events.e]\nbreaks = "a.start"\ntime = 0\n'},
            "events.e.breaks",
            'an end that is free to turn, found "a.start", which keeps a direction',
        ),
        (
            {"wall": tied("block"), "start": '{ joined = "a.start", rigid = true }'},
            "lines.b.start.rigid",
            'an end that is free to turn, found "a.start", which keeps a direction',
        ),
    ],
)
def test_mistakes_of_clamps_on_bodies_are_told(tmp_path, changes, where, said):
    with pytest.raises(SceneError) as caught:
        scene_of(tmp_path, pipes(**changes | {"more": SHIP + changes.get("more", "")}))
    fault = next(f for f in caught.value.faults if f.key == where)
    assert said in fault.message
