"""What a scene says twice, or cannot mean: told when it is read, where it was silently lost before."""

import pytest

from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.outcomes import QUANTITIES, SUMMARIES, TAKEN

LINE = """\
gravity = "9.81 m/s2"

[water]
density = "1025 kg/m3"

[materials.wire]
law = "linear"
EA = "10 MN"

[lines.rope]
material = "wire"
length = "60 m"
segments = 10
mass = "5 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, 0] }
end = { fixed = ["55 m", 0, 0] }

[events.break]
breaks = "rope.end"
time = "5 ms"

[output]
duration = "20 ms"
every = "10 ms"
"""


def read(folder, text, *sets):
    (folder / "scene.toml").write_text(text)
    return load_study(folder / "scene.toml", sets)


def faults(folder, text, *sets):
    with pytest.raises(SceneError) as caught:
        read(folder, text, *sets)
    return [(fault.key, fault.message) for fault in caught.value.faults]


@pytest.mark.parametrize(
    "name", ["peak_tension", "energy_closure", "solver_steps", "reach", "run", "time"]
)
def test_a_measure_is_not_called_like_a_number_of_the_run(tmp_path, name):
    # /summary has one number of a name, and a reference means one of them
    ((key, message),) = faults(tmp_path, f'{LINE}[measures.{name}]\ntension = "rope@30 m"\n')
    assert key == f"measures.{name}"
    assert f'expected another name, found "{name}"' in message
    read(tmp_path, f'{LINE}[measures.my_{name}]\ntension = "rope@30 m"\n')


def test_the_names_that_are_taken_are_all_that_a_run_writes():
    written = {"run", "time", "case", "status", "status_time", "status_message", "written", "xyz"}
    assert {*SUMMARIES, *QUANTITIES, "solver_steps", *written} == TAKEN


@pytest.mark.parametrize(
    ("name", "clashes"), [("rope-1", True), ("rope-2", True), ("rope-3", False)]
)
def test_a_line_is_not_called_like_a_part_of_another(tmp_path, name, clashes):
    # which would be one with it in the results
    own = LINE[LINE.index("[lines.rope]") : LINE.index("[events.break]")].replace("rope", name)
    assert read(tmp_path, LINE + own).scene
    parted = LINE.replace('"rope.end"', '"rope@30 m"') + own
    if not clashes:
        assert read(tmp_path, parted).scene
        return
    ((key, message),) = faults(tmp_path, parted)
    assert key == f"lines.{name}"
    assert message == f'expected another name, found "{name}", a part of "rope" when that breaks'


SHIP = LINE.replace('{ fixed = ["55 m", 0, 0] }', '"ship.bow"')
FREE = """
[bodies.ship]
mass = "100 t"
size = ["50 m", "10 m", "5 m"]
position = ["80 m", 0, 0]
points = { bow = ["-25 m", 0, 0] }
free = ["x"]
"""
MOVED = """
[bodies.ship]
position = ["55 m", 0, 0]
points = { bow = [0, 0, 0] }
motion = """


def test_a_body_has_no_velocity_along_a_way_that_is_not_free(tmp_path):
    text = SHIP + FREE
    ((key, message),) = faults(tmp_path, f'{text}velocity = [0, 0, "-0.5 m/s"]\n')
    assert key == "bodies.ship.velocity.2"
    assert message.endswith('found -0.5 m/s, without "z" in free')
    read(tmp_path, f'{text}velocity = ["1 m/s", 0, 0]\n')
    read(tmp_path, f'{text}velocity = [0, 0, "-0.5 m/s"]\n', "ship.free=[x, z]")


@pytest.mark.parametrize(
    ("motion", "key"),
    [
        ('{ file = "ship.csv", heave = [5, 7] }', "heave"),
        ('{ file = "ship.csv", roll = ["0 deg", "3 deg"], time = [0, 1] }', "time"),
        ('{ rao = "rao.csv", omega = [0.2, 2] }', "omega"),
        ('{ rao = "rao.csv", response = { roll = [[1, 0], [2, 0]] } }', "response"),
    ],
)
def test_a_motion_from_a_file_has_no_lists_of_its_own(tmp_path, motion, key):
    (tmp_path / "ship.csv").write_text("t,heave\n0,0\n1,0\n")
    (tmp_path / "rao.csv").write_text("omega,heave,heave_phase\n0.4,1,0\n0.8,0.5,0.3\n")
    text = f'{SHIP}{MOVED}{motion}\n[sea]\nheight = "1 m"\nperiod = "8 s"\n'
    ((where, message),) = faults(tmp_path, text)
    assert where == f"bodies.ship.motion.{key}"
    assert f"or {key}, found both" in message


JOINED = (
    LINE[: LINE.index("[events")].replace(
        '{ fixed = ["55 m", 0, 0] }', '{ joined = "tail.start", at = ["28 m", 0, "-5 m"] }'
    )
    + """
[lines.tail]
material = "wire"
length = "30 m"
segments = 6
mass = "5 kg/m"
diameter = "50 mm"
start = "rope.end"
end = { fixed = ["55 m", 0, 0] }

[output]
duration = "20 ms"
every = "10 ms"
"""
)
TAIL = 'start = "rope.end"'


@pytest.mark.parametrize(
    ("other", "key"),
    [
        ('{ joined = "rope.end", at = ["26 m", 0, "-6 m"] }', "lines.tail.start.at"),
        ('{ fixed = ["26 m", 0, "-6 m"] }', "lines.rope.end.at"),
        ('{ winch = { at = ["26 m", 0, "-6 m"], tension = "1 kN" } }', "lines.rope.end.at"),
    ],
)
def test_ends_that_are_joined_are_at_one_place(tmp_path, other, key):
    ((where, message),) = faults(tmp_path, JOINED.replace(TAIL, f"start = {other}"))
    assert where == key
    assert message.startswith("expected the place of")
    same = other.replace('"26 m", 0, "-6 m"', '"28 m", 0, "-5 m"')
    read(tmp_path, JOINED.replace(TAIL, f"start = {same}"))


BED = '\n[seabed]\nheight = "-3 m"\nstiffness = "20 kPa"\n'


def test_neither_a_winch_nor_a_joint_is_under_the_bed(tmp_path):
    winch = LINE.replace(
        "{ fixed = [0, 0, 0] }", '{ winch = { at = [0, 0, "-4 m"], tension = "1 kN" } }'
    )
    ((key, message),) = faults(tmp_path, winch + BED)
    assert key == "lines.rope.start.winch.at.2"
    assert message == "expected -3 m or more, the height of the seabed, found -4 m"
    ((key, message),) = faults(tmp_path, JOINED + BED)
    assert key == "lines.rope.end.at.2"
    assert message.endswith("found -5 m")


def test_a_current_does_not_grow_without_bound_with_depth(tmp_path):
    current = '{ profile = "power", velocity = [1, 0, 0], exponent = -0.5, depth = "50 m" }'
    ((key, message),) = faults(tmp_path, LINE, f"water.current={current}")  # told alone
    assert (key, message) == (
        "water.current.exponent",
        "expected a non-negative number, found -0.5",
    )
    drag = "rope.drag={ normal = 1, tangential = 0 }"
    read(tmp_path, LINE, f"water.current={current.replace('-0.5', '0')}", drag)


def test_a_break_begins_before_the_run_ends(tmp_path):
    for start in ("20 ms", "1 s"):
        ((key, message),) = faults(tmp_path, LINE, f"break.start={start}")
        assert key == "events.break.start"
        assert message == f"expected a time before the run ends at 20 ms, found {start}"
    read(tmp_path, LINE, "break.start=19.9 ms")
    # in a sweep the run that does not see its break is told
    ((key, _),) = faults(tmp_path, LINE, "break.start=[1 ms, 30 ms]")
    assert key == 'sweep."events.break.start".1'


def test_a_run_lasts_a_whole_number_of_output_intervals(tmp_path):
    # at 100 ms it would end after the one of 60 ms: what happens at 70 ms would not
    ((key, message),) = faults(tmp_path, LINE, "duration=100 ms", "every=60 ms")
    assert key == "output.duration"
    assert message == (
        "expected a whole number of times every, 60 ms: 60 ms or 120 ms, found 100 ms"
    )


@pytest.mark.parametrize("every", [1e-4, 1e-6, 1.0 / 3.0, 0.7, 1e-3])
@pytest.mark.parametrize("count", [1, 3, 7, 1000])
def test_rounded_numbers_are_whole_numbers_of_intervals(tmp_path, every, count):
    for duration in (count * every, float(f"{count * every:.11g}")):
        study = read(tmp_path, LINE, f"every={every!r}", f"duration={duration!r}")
        assert study.scene.output.count == count


def test_a_misspelt_freedom_of_a_response_is_told_where_it_stands(tmp_path):
    motion = (
        "{ omega = [0.4, 0.8], response = { heave = [[1, 0], [1, 0]], rol = [[1, 0], [1, 0]] } }"
    )
    text = f'{SHIP}{MOVED}{motion}\n[sea]\nheight = "1 m"\nperiod = "8 s"\n'
    ((key, message),) = faults(tmp_path, text)
    assert key == "bodies.ship.motion.response.rol"
    assert 'did you mean "roll"' in message


def test_a_stop_asks_for_steps_at_each_of_which_the_body_is_looked_at(tmp_path):
    # a method that chooses its steps would go on past the rest, and say that it still moves
    text = LINE.split("[events.break]")[0].replace(
        'end = { fixed = ["55 m", 0, 0] }', 'end = "ship"'
    )
    text += '[bodies.ship]\nmass = "1 t"\nposition = ["59 m", 0, 0]\nvelocity = ["1 m/s", 0, 0]\n'
    text += 'free = ["x"]\n[output]\nduration = "2 s"\nevery = "10 ms"\nstop = "ship"\n'
    read(tmp_path, text)
    read(tmp_path, text, "solver.method=dopri5", "solver.step=1 ms")
    ((key, message),) = faults(tmp_path, text, "solver.method=dopri5")
    assert key == "output.stop"
    assert message.startswith(
        "expected solver.step or solver.courant where the rest of a body ends"
    )


def test_a_body_that_displaces_more_than_its_box_is_told(tmp_path):
    text = LINE.split("[events.break]")[0].replace(
        'end = { fixed = ["55 m", 0, 0] }', 'end = "ship"'
    )
    text = text.replace("[water]", "[water]\nsurface = 0")
    text += '[bodies.ship]\nmass = "1 t"\nposition = ["59 m", 0, 0]\n'
    text += 'size = [20, 10, 3]\nvolume = "VOLUME m3"\n[output]\nduration = 1\nevery = 1\n'
    ((key, message),) = faults(tmp_path, text.replace("VOLUME", "1800"))
    assert key == "bodies.ship.volume"
    told = "expected at most that of its box, 600 m3, of a body that floats, found 1800 m3"
    assert message == told
    read(tmp_path, text.replace("VOLUME", "600.5"))
