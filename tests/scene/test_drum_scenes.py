"""Lines on drums in the scene language: what reads, and what is refused."""

import pytest

from lumpedcable.scene import SceneError, load_study

AT = "[0, 0, 10]"
SCHEDULE = '{ time = ["0 s", "2 s"], speed = ["0 m/s", "-0.5 m/s"] }'
DRUM = f"{{ drum = {{ at = {AT}, schedule = {SCHEDULE} }} }}"
LINE = f"""
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
[bodies.load]
mass = 100
[bodies.ship]
position = [0, 0, 0]
motion.surge = {{ amplitude = 1, period = 5 }}
points = {{ tip = [0, 0, 12] }}
[lines.wire]
material = "wire"
length = "8 m"
segments = 4
mass = 1
start = {DRUM}
end = "load"
[output]
duration = 5
every = 0.1
"""
TROLLEY = '[bodies.cargo]\nmass = 10\non = { line = "wire", place = 2 }\n'
CUT = '[events.cut]\nbreaks = "{}"\nstart = 1\ntime = 0.1\n'
OTHER = """
[lines.other]
material = "wire"
length = 5
segments = 2
mass = 1
start = {}
end = {{ fixed = [0, 3, 0] }}
"""


def written(folder, text, *overrides):
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return load_study(path, list(overrides))


def faults(folder, text, *overrides):
    with pytest.raises(SceneError) as caught:
        written(folder, text, *overrides)
    return [(fault.key, fault.message) for fault in caught.value.faults]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("a", "a"),
        (AT, '"ship.tip"'),
        (DRUM, "AWAY"),
        ('time = ["0 s", "2 s"], speed = ["0 m/s", "-0.5 m/s"]', "time = [3], speed = [1]"),
        ('end = "load"', 'end = "free"'),
        ('end = "load"', "end = { held = { pretension = 10, direction = [1, 0, 0] } }"),
        ('end = "load"', f'end = "other.start"\n{OTHER.format(chr(34) + "wire.end" + chr(34))}'),
        ('end = "load"', f"end = {{ fixed = [5, 0, 5] }}\n{CUT.format('wire.end')}"),
        ('length = "8 m"', 'length = "2 m"\npayout = { speed = 1, time = 3 }'),
    ],
)
def test_a_drum_reads(tmp_path, old, new):
    text = LINE.replace(old, new)
    if new == "AWAY":  # at the other end
        text = text.replace('end = "load"', f"end = {DRUM}").replace("AWAY", '"load"')
    assert old in LINE
    study = written(tmp_path, text)
    assert "drum" in study.scene.model_dump_json()


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        (AT, '"ship.top"', "lines.wire.start.drum.at",
         'expected a point of a moved body, found "ship.top"; did you mean "ship.tip"'),
        (AT, '"load"', "lines.wire.start.drum.at", "expected a point of a moved body"),
        ('["0 s", "2 s"]', '["0 s"]', "lines.wire.start.drum.schedule.speed",
         "expected 1 speeds, one per time, found 2"),
        ('["0 s", "2 s"]', "[]", "lines.wire.start.drum.schedule.time",
         "expected at least one time, found none"),
        ('["0 s", "2 s"]', '["2 s", "1 s"]', "lines.wire.start.drum.schedule.time.1",
         "expected more than 2 s, the time before, found 1 s"),
        ('["0 s", "2 s"]', '["-1 s", "2 s"]', "lines.wire.start.drum.schedule.time.0",
         "expected a non-negative time (s), found"),
        ('["0 m/s", "-0.5 m/s"]', '["0 m/s", "-2 m/s"]', "lines.wire.start.drum.schedule.speed",
         "expected speeds that leave more than 80 mm of the line out, found 8 m of its 8 m hauled in by "
         "5 s"),
        ('end = "load"', f"end = {DRUM}", "lines.wire.end",
         "expected one drum on a line, found one at either end"),
        ('end = "load"', "end = { winch = { at = [5, 0, 5], tension = 1000 } }", "lines.wire.start",
         "expected a drum or a winch on a line, found a drum at one end and a winch at the other"),
        ('law = "linear"\nEA = "1 MN"', 'law = "inextensible"', "lines.wire.start",
         "expected an elastic line on a drum, found an inextensible one"),
        ("segments = 4", 'segments = 4\nmodel = "ideal"', "lines.wire.start.drum",
         'expected model = "lumped" for a line on a drum, found "ideal"'),
        ("[output]", f"{TROLLEY}[output]", "bodies.cargo.on.line",
         'expected a line without a drum where a body runs on it, found "wire"'),
        ("[output]", f"{CUT.format('wire.start')}[output]", "events.cut.breaks",
         'expected "wire.end", the end across from the drum, or a line without a drum, found '
         '"wire.start", which its drum holds'),
        ("[output]", f'{CUT.format("wire")}place = "4 m"\n[output]', "events.cut.breaks",
         'found a place along "wire", all of which the drum at its start pays out'),
        ("[output]", OTHER.format('"wire.start"') + "[output]", "lines.other.start",
         'expected a place, a body or the end of a line without a drum there, found "wire.start"'),
        ("[output]", OTHER.format('{ joined = "wire.start", at = [0, 0, 10] }') + "[output]",
         "lines.other.start", 'the end of a line without a drum there, found "wire.start"'),
        ("[output]", "[seabed]\nheight = 20\nstiffness = 1e5\n[output]", "lines.wire.start.drum.at.2",
         "expected 20 m or more, the height of the seabed, found 10 m"),
    ],
)  # fmt: skip
def test_what_is_no_drum_is_told(tmp_path, old, new, key, words):
    assert old in LINE
    told = dict(faults(tmp_path, LINE.replace(old, new, 1)))
    assert key in told
    assert words in told[key]


@pytest.mark.parametrize(
    ("time", "speed", "duration", "least", "when"),
    [
        ([0.0], [-0.5], 4.0, -2.0, 4.0),
        ([0.0, 2.0], [-1.0, 1.0], 5.0, -0.5, 1.0),  # turns between two times
        ([1.0, 2.0], [0.0, 1.0], 5.0, 0.0, 0.0),
        ([1.0, 3.0, 3.5], [1.0, -3.0, 0.0], 3.25, 1.0 - 2.25 - 0.5 * (3.0 + 1.5) * 0.25 + 0.25, 3.25),
        ([10.0, 11.0], [-1.0, 4.0], 5.0, -5.0, 5.0),
    ],
)  # fmt: skip
def test_the_least_that_is_out(tmp_path, time, speed, duration, least, when):
    told = f"{{ time = {time}, speed = {speed} }}"
    study = written(tmp_path, LINE.replace(SCHEDULE, told))
    found = study.scene.lines["wire"].start.drum.schedule.least_way(duration)
    assert found == pytest.approx((min(least, 0.0), when if least < 0.0 else 0.0))


def test_every_run_of_a_sweep_is_asked_how_much_it_hauls_in(tmp_path):
    text = LINE + '[sweep]\n"lines.wire.start.drum.schedule.speed.1" = ["-1 m/s", "-3 m/s"]\n'
    ((key, message),) = faults(tmp_path, text)
    assert "speed" in key
    assert "hauled in" in message
