"""Trolleys, winches and measures in the scene language: what is wrong with what does not read."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import equilibrium_of, scene_of

from lumpedcable.exact import IdealHighline
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
        ([WHOLE, ('place = "1 m"', 'place = "0.7 m"')], "bodies.cargo.on.place",
         "expected a place at least a segment, 750 mm, from either post, found 700 mm on a span of "
         "60 m: move it, or take more segments"),
        ([WHOLE, ('place = "1 m"', 'place = "59.5 m"')], "bodies.cargo.on.place",
         "found 59.5 m on a span of 60 m"),
        ([WHOLE, ('stop = "2 m"', 'stop = "0.7 m"')], "bodies.cargo.on.stop",
         "expected a stop at least a segment, 750 mm, from the line's end, found 700 mm"),
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
         "expected the name of a moved body, found"),
        ([('over = "receiver"', 'over = "sea"')], "measures.h_d.over",
         "expected [sea], whose waves it is over, found none"),
        ([('over = "receiver"', 'over = "sea"'), ("[measures.h_d]",
           '[sea]\nheight = "1 m"\nperiod = "8 s"\n[bodies.sea]\nmass = 1\n[measures.h_d]')],
         "bodies.sea", 'expected another name where a height is over = "sea", the waves, found "sea"'),
        ([('over = "receiver"', 'over = "see"'),
          ("[measures.h_d]", '[sea]\nheight = "1 m"\nperiod = "8 s"\n[measures.h_d]')],
         "measures.h_d.over", 'expected the name of a moved body, or "sea"'),
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


def test_a_trolley_may_be_a_segment_from_a_post_and_nearer_on_an_ideal_line(tmp_path):
    text = TRANSFER.read_text()
    text = text[: text.index("[sweep]")] + text[text.index("[solver]") :]
    (tmp_path / "scene.toml").write_text(text)
    at = "bodies.cargo.on"
    for changes in (
        [f"{at}.place=0.75", f"{at}.stop=0.75", "highline.model=lumped"],
        [f"{at}.place=0.25", f"{at}.stop=0.25"],
    ):
        on = load_study(tmp_path / "scene.toml", changes).runs[0].bodies["cargo"].on
        assert on.place == on.stop < 1.0


# 1 t at 40 kN, 5 m in 50 segments of a wire that is all but weightless
SPAN = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "57.1 MN"
[bodies.cargo]
mass = "1 t"
on = {{ line = "wire", place = {place} }}
[lines.wire]
material = "steel"
length = "5 m"
segments = 50
mass = "1 g/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ winch = {{ at = [5, 0, 0], tension = "40 kN" }} }}
[output]
"""


@pytest.mark.parametrize(
    "place", [*(pytest.param(x, marks=pytest.mark.slow) for x in (0.1, 0.15)), 4.9]
)
@pytest.mark.slow
def test_from_a_segment_on_the_line_hangs_as_it_should(tmp_path, place):
    found, coordinates = equilibrium_of(scene_of(tmp_path, SPAN.format(place=place)))
    at = coordinates.expand(np.asarray(found.model.bodies["cargo"].reference)[:2], 0, place=True)
    # two straight parts of the tension of the winch; half a segment from a post it would be 4 % off
    assert at[2] == pytest.approx(
        IdealHighline(5.0, 40e3, 1e3, 9.81, place=place).height(), rel=0.01
    )


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
        ('"tail.start"', "{ motion = { position = [55, 0, 0] } }"),
    ],
)
def test_what_holds_the_end_across_from_a_winch_may_be_any_place(tmp_path, end, start):
    (tmp_path / "scene.toml").write_text(ACROSS.replace("END", end).replace("START", start))
    load_study(tmp_path / "scene.toml")
