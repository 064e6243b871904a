"""Targets, lines paid out and scenes at rest: what is read, and what is told of mistakes."""

import good_scenes
import pytest

from lumpedcable.scene import SceneError, load_study

SCENE = """
gravity = "10 m/s2"

[materials.wire]
law = "linear"
EA = "75 MN"

[bodies.cargo]
mass = "2 t"

[lines.before]
material = "wire"
length = "30 m"
payout = { speed = "0.5 m/s", time = "4 s" }
segments = 4
mass = "4 kg/m"
start = { fixed = [0, 0, 0] }
end = "cargo"

[lines.after]
material = "wire"
length = "33 m"
segments = 4
mass = "4 kg/m"
start = "cargo"
end = { fixed = [60, 0, -16] }

[targets.winch]
change = "lines.after.length"
of = "before.start"
tension = "80 kN"

[sweep]
"targets.winch.tension" = ["60 kN", "80 kN"]

[output]
"""


def load(tmp_path, text):
    return load_study(good_scenes.write(tmp_path, text), [])


def test_a_line_has_its_length_from_its_winch_or_from_a_target(tmp_path):
    end = "end = { fixed = [60, 0, -16] }"
    with pytest.raises(SceneError, match='expected a line without a winch, found "after"'):
        load(
            tmp_path,
            SCENE.replace(end, 'end = { winch = { at = [60, 0, -16], tension = "9 kN" } }'),
        )


def test_a_scene_at_rest_is_read(tmp_path):
    study = load(tmp_path, SCENE)
    scene = study.runs[0]
    target = scene.targets["winch"]
    assert (target.measure, target.wanted, target.line) == ("tension", 60e3, "after")
    assert scene.output.static
    assert scene.lines["before"].unstretched == 32.0
    assert scene.numbers()["targets.winch.tension"] == 60e3
    # what a target asks for is a number: another one is no other structure
    assert scene.skeleton() == study.runs[1].skeleton()


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('"lines.after.length"', '"lines.aftr.length"', "targets.winch.change",
         ['the length of a line, "lines.NAME.length"', 'did you mean "lines.after.length"']),
        ('"lines.after.length"', '"lines.after.mass"', "targets.winch.change",
         ["the length of a line"]),
        ('"before.start"', '"before"', "targets.winch.of", ["the end of a line", '"before"']),
        ('"before.start"', '"befor.start"', "targets.winch.of", ['did you mean "before.start"']),
        ('tension = "80 kN"', 'x = "3 m"\nz = "4 m"', "targets.winch",
         ["expected one of tension, x, y, z, sag or length, found x and z"]),
        ('tension = "80 kN"', "", "targets.winch", ["found none"]),
        ('tension = "80 kN"', 'tension = "80 m"', "targets.winch.tension", ["positive force (N)"]),
        ('of = "before.start"\ntension = "80 kN"', 'of = "before + cargo"\nlength = "60 m"',
         "targets.winch.of", ['several as "NAME + NAME"', '"cargo"']),
        ('of = "before.start"\ntension = "80 kN"', 'of = "before + after"\nsag = "6 m"',
         "targets.winch.of", ["expected a line"]),
        ("[sweep]", '[targets.again]\nchange = "lines.after.length"\nof = "cargo"\nx = 3\n\n[sweep]',
         "targets.again.change", ['each length once, found that of target "winch" again']),
        ("[output]", '[output]\nduration = "1 s"', "output.every",
         ["duration and every together, or neither"]),
        ("[output]", '[output]\nevery = "1 s"', "output.duration",
         ["duration and every together, or neither"]),
        ("[sweep]", '[events.cut]\nbreaks = "after@10 m"\ntime = 0\n\n[sweep]', "output",
         ["expected a duration where there are events"]),
        ('speed = "0.5 m/s"', 'speed = "-8 m/s"', "lines.before.payout.time",
         ["expected less time, found 4 s"]),
    ],
)  # fmt: skip
def test_a_mistake_is_told(tmp_path, old, new, key, words):
    text = SCENE.replace(old, new)
    if "tension = " not in new and "tension" in old:
        text = text[: text.index("[sweep]")] + "[output]\n"
    with pytest.raises(SceneError) as caught:
        load(tmp_path, text)
    (fault,) = caught.value.faults
    assert fault.key == key
    for word in words:
        assert word in fault.message
