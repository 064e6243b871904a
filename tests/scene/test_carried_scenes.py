"""Trolleys, winches and measures in the scene language: what is wrong with what does not read."""

from pathlib import Path

import pytest

from lumpedcable.scene import SceneError, load_study

TRANSFER = Path(__file__).parents[2] / "configs" / "highline" / "transfer.toml"


def faults(folder, *edits):
    text = TRANSFER.read_text()
    text = text[: text.index("[sweep]")] + text[text.index("[solver]") :]
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "scene.toml").write_text(text)
    with pytest.raises(SceneError) as caught:
        load_study(folder / "scene.toml")
    return [(fault.key, fault.message) for fault in caught.value.faults]


ON = 'on = { line = "highline", place = "1 m", speed = "1 m/s", stop = "2 m" }'

WHOLE = ('model = "ideal"', 'model = "lumped"')
CUT = '[events.cut]\nbreaks = "{}"\nstart = 1\ntime = 0.1\n[solver]'
WINCH = 'end = { winch = { at = "receiver.post", tension = "80 kN" } }'
SWAPPED = [
    (WINCH, 'end = "receiver.post"'),
    ('start = "supply.post"', 'start = { winch = { at = "supply.post", tension = "80 kN" } }'),
]


@pytest.mark.parametrize(
    ("edits", "key", "words"),
    [
        ([('place = "1 m"', 'place = "61 m"')], "bodies.cargo.on.place",
         'expected a place on the span of "highline", between 0 m and 60 m, found 61 m'),
        ([('tension = "80 kN"', 'tension = "9 kN"')], "lines.highline.end.winch.tension",
         'expected more than 9.81 kN, half the weight of "cargo"'),
        ([('level = "11 m"', 'level = "17 m"')], "measures.h_d.level",
         "expected a deck below receiver.post, which is at 16.2 m, found 17 m"),
        ([('level = "11 m"\nnear = "receiver.post"\nwithin = "15 m"', 'level = "16.5 m"')],
         "measures.h_d.level", "expected a deck below receiver.post, which is at 16.2 m"),
        ([('stop = "2 m"', 'stop = "59 m"')], "bodies.cargo.on.stop", "expected room to haul it"),
        ([('line = "highline"', 'line = "highlin"')], "bodies.cargo.on.line",
         'did you mean "highline"'),
        ([('at = "receiver.post"', 'at = "receiver.pst"')], "lines.highline.end.winch.at",
         'did you mean "receiver.post"'),
        ([('end = { winch = { at = "receiver.post", tension = "80 kN" } }',
           'end = "receiver.post"')], "bodies.cargo.on.line", "expected a winch"),
        ([(ON, ON.replace(', speed = "1 m/s"', ""))], "measures.h_d.while_hauled",
         "expected a body that is hauled"),
        ([('height = "cargo"', 'height = "carg"')], "measures.h_d.height", 'did you mean "cargo"'),
        ([('over = "receiver"', 'over = "cargo"')], "measures.h_d.over",
         "expected the name of a moved body"),
        ([('mass = "2 t"', 'mass = "2 t"\ndepth = "1 m"')], "bodies.cargo.inertia",
         "expected depth and inertia together"),
        ([(ON, ON.replace(" }", ", friction = { coefficient = 0.1 } }"))], "bodies.cargo.on.friction",
         'expected model = "lumped" for a trolley with friction, or no friction, found "ideal"'),
        ([(ON, ON.replace(" }", ", contact = { stiffness = 1e7 } }"))], "bodies.cargo.on.contact",
         'expected model = "lumped" for a trolley with contact'),
        ([('tension = "80 kN" }', 'tension = "80 kN", inertia = "1 t" }')],
         "lines.highline.end.winch.inertia", 'expected model = "lumped" for a winch with inertia'),
        ([('tension = "80 kN" }', 'tension = "80 kN", damping = "1 kN s/m" }')],
         "lines.highline.end.winch.damping", 'expected model = "lumped" for a winch with damping'),
        ([('model = "ideal"', 'model = "ideal"\nbending = { EI = "60 N m2" }')],
         "lines.highline.bending",
         'expected model = "lumped" for a line with bending, or no bending, found "ideal", which is two '
         "straight parts without mass"),
        ([("[solver]", '[events.cut]\nbreaks = "highline.end"\nstart = 1\ntime = 0.1\n[solver]')],
         "events.cut.breaks", 'expected model = "lumped" for a line that breaks'),
        ([WHOLE, ("[solver]", CUT.format("highline.end"))], "events.cut.breaks",
         'expected "highline.start", the end across from the winch, or a line without a winch, found '
         '"highline.end", which its winch holds'),
        ([WHOLE, ("[solver]", CUT.format("highline@20 m"))], "events.cut.breaks",
         'expected "highline.start", the end across from the winch, or a line without a winch, found a '
         'place along "highline", all of which the winch at its end pays out'),
        ([WHOLE, *SWAPPED, ("[solver]", CUT.format("highline.start"))], "events.cut.breaks",
         'expected "highline.end", the end across from the winch, or a line without a winch, found '
         '"highline.start", which its winch holds'),
        ([('position = [0, "60 m", 0]', 'position = ["10 m", "60 m", 0]')],
         "bodies.cargo.on.speed", "found it aslant"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_where_it_is(tmp_path, edits, key, words):
    found = dict(faults(tmp_path, *edits))
    assert key in found
    assert words in found[key]


def test_a_line_may_break_across_from_its_winch(tmp_path):
    # its winch goes on hauling what is left of it
    edits = [WHOLE, ("[solver]", CUT.format("highline.start"))]
    text = TRANSFER.read_text()
    text = text[: text.index("[sweep]")] + text[text.index("[solver]") :]
    for old, new in edits:
        text = text.replace(old, new, 1)
    (tmp_path / "scene.toml").write_text(text)
    assert load_study(tmp_path / "scene.toml").runs[0].events["cut"].breaks == "highline.start"


ACROSS = """\
gravity = "9.81 m/s2"
[materials.wire]
law = "linear"
EA = "10 MN"
[lines.rope]
material = "wire"
length = "60 m"
segments = 10
mass = "5 kg/m"
start = { winch = { at = [0, 0, 0], tension = "20 kN" } }
end = END
[lines.tail]
material = "wire"
length = "20 m"
segments = 10
mass = "5 kg/m"
start = START
end = { fixed = ["70 m", 0, 0] }
[bodies.bob]
mass = "50 kg"
[bodies.ship]
mass = "50 t"
size = ["10 m", "5 m", "5 m"]
position = ["65 m", 0, 0]
points = { bow = ["-5 m", 0, 0] }
[output]
"""
THERE = '{ fixed = ["55 m", 0, 0] }'


@pytest.mark.parametrize(
    ("end", "start", "what"),
    [
        ('"free"', THERE, "found a free end"),
        ('{ held = { pretension = "1 kN", direction = [1, 0, 0] } }', THERE, "found a force"),
        ('"bob"', '"bob"', 'found the point mass "bob"'),
        ('"tail.start"', '"rope.end"', 'found a joint with "tail.start"'),
        ('{ joined = "tail.start", at = ["55 m", 0, 0] }', '"free"', 'a joint with "tail.start"'),
    ],
)
def test_something_holds_the_end_across_from_a_winch(tmp_path, end, start, what):
    scene = tmp_path / "scene.toml"
    scene.write_text(ACROSS.replace("END", end).replace("START", start))
    with pytest.raises(SceneError) as caught:
        load_study(scene)
    (fault,) = caught.value.faults
    assert (fault.key, fault.line) == ("lines.rope.end", 11)
    assert what in fault.message


@pytest.mark.parametrize(
    ("end", "start"),
    [
        (THERE, '"rope.end"'),
        ("{ motion = { position = [55, 0, 0] } }", '"free"'),
        ('{ held = { position = ["55 m", 0, 0] } }', '"free"'),
        ('"ship.bow"', '"ship"'),
        ('"ship"', '"free"'),
        ('"tail.start"', THERE),
    ],
)
def test_what_holds_the_end_across_from_a_winch_may_be_any_place(tmp_path, end, start):
    (tmp_path / "scene.toml").write_text(ACROSS.replace("END", end).replace("START", start))
    load_study(tmp_path / "scene.toml")
