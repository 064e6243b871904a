"""A catalogue of mistakes: each gives exactly one fault, on its line, that says what was meant."""

import pickle
import re
import tomllib
from contextlib import contextmanager, suppress

import good_scenes
import pytest
from mistakes import MISTAKES, PRETENSION, spoilt

from lumpedcable.scene import Fault, Scene, SceneError, load_study, read_scene
from lumpedcable.scene.tree import Spot, paths

ROPE, BRIDLE = good_scenes.ROPE, good_scenes.BRIDLE


def faults_of(path, overrides=()):
    with pytest.raises(SceneError) as caught:
        load_study(path, overrides)
    return caught.value.faults


@pytest.mark.parametrize(("text", "edits", "key", "words", "at"), MISTAKES)
def test_one_mistake_is_one_fault_on_its_line(tmp_path, text, edits, key, words, at):
    bad = spoilt(text, edits)
    path = good_scenes.write(tmp_path, bad)
    (fault,) = faults_of(path)
    assert fault.key == key
    assert (fault.file, fault.line) == (str(path), bad[: bad.index(at)].count("\n") + 1)
    for word in words:
        assert word in fault.message
    assert fault.message.startswith("expected ")
    assert ", found " in fault.message
    assert str(fault) == ": ".join(filter(None, (f"{path}:{fault.line}", key, fault.message)))


def test_the_catalogue_is_large_and_its_names_are_unique():
    names = [mistake.id for mistake in MISTAKES]
    assert len(names) == len(set(names)) >= 100


@pytest.mark.parametrize("text", [ROPE, BRIDLE])
def test_the_scenes_that_are_spoilt_are_right_before(tmp_path, text):
    assert load_study(good_scenes.write(tmp_path, text)).runs


# --- files ---------------------------------------------------------------------------------------


def test_no_file(tmp_path):
    good_scenes.write(tmp_path, ROPE)
    (fault,) = faults_of(tmp_path / "scen.toml")
    assert (fault.line, fault.key) == (None, "")
    assert "expected a file, found none" in fault.message
    assert fault.message.endswith('; did you mean "scene.toml"?')


def test_a_directory_for_a_file(tmp_path):
    (fault,) = faults_of(tmp_path)
    assert str(fault) == f"{tmp_path}: expected a file, found a directory"


@pytest.mark.parametrize("text", ["", "\n\n", "# nothing but a remark\n"])
def test_an_empty_file(tmp_path, text):
    (fault,) = faults_of(good_scenes.write(tmp_path, text))
    assert (fault.line, fault.message) == (1, "expected a scene, found an empty file")


def test_text_in_another_encoding(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes(ROPE.replace("A rope", "Ein Stück").encode("latin-1"))
    (fault,) = faults_of(path)
    assert "expected UTF-8 text, found byte 0xfc in line 1" in fault.message


def test_deep_nesting_is_no_crash(tmp_path):
    (fault,) = faults_of(good_scenes.write(tmp_path, "a = " + "[" * 100_000))
    assert "expected TOML" in fault.message


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("strain,force\n0,0\n1,1\n", "expected the columns strain, tension, found strain, force"),
        ("0,0\n1,1\n", "expected the columns strain, tension, found 0, 0 in tested.csv:1"),
        ("", "expected the columns strain, tension, found nothing in tested.csv"),
        ("strain,tension\n0,0\n1,x\n", 'number in column tension, found "x" in tested.csv:3'),
        ("strain,tension\n0,0\n\n1\n", "number in column tension, found nothing in tested.csv:4"),
        ("strain,tension\n0,nan\n1,1\n", 'found "nan" in tested.csv:2'),
        ("strain,tension\n0,0\n0.1,1,000\n", "expected 2 cells, as in the header, found 3"),
        ("strain,tension,tension\n0,0,1\n1,1,2\n", "expected one column tension, found 2"),
        ("strain,tension\n0,0\n1,0_3\n", 'number in column tension, found "0_3" in tested.csv:3'),
        ("strain,tension\n0,0\n1,\u0663\n", 'found "\u0663" in tested.csv:3'),
        ("strain,tension\n0,0\n1,infinity\n", 'found "infinity" in tested.csv:3'),
        ('strain,tension\n0,0\n1,"3\n', 'every quote closed, found "1,"3" in tested.csv:3'),
        pytest.param(
            "strain,tension\n0,0\n1," + 140_000 * "3",
            'cells of at most 131072 characters, every quote closed, found "1,333',
            id="long",
        ),
        pytest.param(140_000 * "s" + ",tension\n0,0\n", "in tested.csv:1", id="long name"),
        ("strain,tension\n0,0\n", "expected at least 2 points"),
        ("strain,tension\n0,0\n0,1\n", "expected strains that increase"),
        ("strain,tension\n0,5\n1,1\n", "expected tensions that never fall, found 1 N after 5 N"),
        ("strain,tension\n0,5\n1,5\n", "expected a tension that rises"),
    ],
)
def test_a_bad_table_file_is_one_fault_where_it_is_named(tmp_path, content, words):
    path = good_scenes.write(tmp_path, BRIDLE)
    (tmp_path / "tested.csv").write_text(content)
    (fault,) = faults_of(path)
    assert fault.key in ("materials.tested.file", "materials.tested")
    assert words in fault.message


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("t,x,y\n0,0,0\n1,0,0\n", "expected the columns t, x, y, z, found t, x, y"),
        ("t,x,y,z\n0,0,0,0\n", "expected at least 2 times, found 1"),
        ("t,x,y,z\n0,0,0,0\n0,1,0,0\n", "expected times that increase, found 0 s after 0 s"),
        ("t,x,y,z\n0,0,0,0\n1,,0,0\n", "number in column x, found nothing in tail.csv:3"),
    ],
)
def test_a_bad_motion_file_is_one_fault_where_it_is_named(tmp_path, content, words):
    path = good_scenes.write(tmp_path, BRIDLE)
    (tmp_path / "tail.csv").write_text(content)
    (fault,) = faults_of(path)
    assert fault.key == "lines.tail.end.motion.file"
    assert words in fault.message


# --- many at once --------------------------------------------------------------------------------


def test_all_faults_are_told_at_once_sorted_by_line(tmp_path):
    bad = (
        ROPE.replace('"200 ms"', '"200 m"')
        .replace("p2 = 10.2", 'p2 = "x"')
        .replace('"50 mm"', '"50 mN"')
        .replace('"rope.end"', '"rop.end"')
        .replace('"180 kN"', '"180 kg"')
        .replace("density", "densty")
    )
    faults = faults_of(good_scenes.write(tmp_path, bad))
    assert [fault.key for fault in faults] == [
        "water.densty",
        "materials.nylon.p2",
        "lines.rope.diameter",
        "events.break.breaks",
        f'sweep."{PRETENSION}".1',
        "output.duration",
    ]
    lines = [fault.line for fault in faults]
    assert lines == sorted(lines)


def test_the_error_prints_as_one_line_per_fault(tmp_path):
    bad = ROPE.replace('"60 m"', '"60 kN"').replace("p2 = 10.2", "p2 = true")
    path = good_scenes.write(tmp_path, bad)
    with pytest.raises(SceneError) as caught:
        load_study(path)
    printed = str(caught.value).splitlines()
    assert printed == [
        f"{path}:10: materials.nylon.p2: expected a number, found true",
        f'{path}:17: lines.rope.length: expected a positive length (m), found a force (N), "60 kN"',
    ]


def test_what_names_a_broken_part_is_left_alone(tmp_path):
    # The material, the line and the water cannot be read; nothing that needs them is told.
    bad = (
        ROPE.replace("p2 = 10.2", "p2 = true")
        .replace('"60 m"', "true")
        .replace('"1025 kg/m3"', "true")
    )
    faults = faults_of(good_scenes.write(tmp_path, bad))
    assert [fault.key for fault in faults] == [
        "water.density",
        "materials.nylon.p2",
        "lines.rope.length",
    ]


def test_lines_as_a_list_is_one_fault(tmp_path):
    bad = ROPE.replace("[lines.rope]", "[[lines]]").replace(
        '[sweep]\n"lines.rope.end.held.pretension" = ["45 kN", "180 kN"]\n', ""
    )
    (fault,) = faults_of(good_scenes.write(tmp_path, bad.replace("[0.1, nan]", "[0.1]")))
    assert (fault.key, fault.message) == ("lines", "expected a table, found a list of 1")


def test_no_line(tmp_path):
    text = "[output]\nduration = 1\nevery = 1\n"
    (fault,) = faults_of(good_scenes.write(tmp_path, text))
    assert fault.key == "lines"
    assert "expected at least one line, [lines.NAME], found none" in fault.message


# --- overrides -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "key", "words"),
    [
        ("pretension=90 m", PRETENSION, ["expected a non-negative force (N), found a length (m)"]),
        ("pretension=600 kN", PRETENSION, ["expected at most 531.654 kN"]),
        ("pretension=[1 kN, 2 m]", f'sweep."{PRETENSION}".1', ["found a length (m)"]),
        ("pretension=[1 kN, 600 kN]", f'sweep."{PRETENSION}".1', ["expected at most 531.654 kN"]),
        ("pretension=[]", f'sweep."{PRETENSION}"', ["expected a list of values"]),
        ("pretensoin=90 kN", "", ['found "pretensoin"', f'did you mean "{PRETENSION}"']),
        ("zzz=3", "", ['expected the path of a value, found "zzz"']),
        ("pretension", "", ["expected KEY=VALUE", 'found "pretension"']),
        ("=3", "", ["expected KEY=VALUE"]),
        ("length=", "", ["expected KEY=VALUE"]),
        ("sweep.length=3", "", ["expected the path of the number itself"]),
        ("damping=true", "materials.nylon.damping", ["found true"]),
        ("solver.dtype=float23", "solver.dtype", ['did you mean "float32"']),
        ("breaks=rope@70 m", "events.break.place", ["found 70 m"]),
        ("output.every=[1, 2]", 'sweep."output.every"', ["all runs share one [output]"]),
        ("segments=1e3", "lines.rope.segments", ["expected a whole number", "found 1000.0"]),
        ("fixed.3=1", "", ['found "fixed.3"']),
        ("lines.roap.length=3", "", ['did you mean "lines.rope.length"']),
        ("mass=1\nlength=3", "lines.rope.mass", ['found "length=3", which is not a unit']),
        ("mass=1\n[lines]", "lines.rope.mass", ['found "[lines]", which is not a unit']),
        (f"fixed.{4301 * '1'}=1", "", ['found "fixed.1']),
        ("mass=1 ((km9)9)9", "lines.rope.mass", ["a unit whose size is beyond arithmetic"]),
        ("direction=[0, 0, 0]", "lines.rope.end.held.direction", ["zero vector"]),
    ],
)
def test_a_wrong_override_is_one_fault_that_names_it(tmp_path, override, key, words):
    (fault,) = faults_of(good_scenes.write(tmp_path, ROPE), [override])
    assert (fault.override, fault.line, fault.key) == (override, None, key)
    assert str(fault).startswith(f"--set {override}: ")
    for word in words:
        assert word in fault.message


def test_an_ambiguous_override_lists_what_it_could_mean(tmp_path):
    (fault,) = faults_of(good_scenes.write(tmp_path, BRIDLE), ["mass=3"])
    assert "lines.upper.mass, lines.lower.mass, lines.tail.mass, bodies.bob.mass" in fault.message


def test_faults_of_file_and_overrides_come_together(tmp_path):
    path = good_scenes.write(tmp_path, ROPE.replace("p2 = 10.2", "p2 = true"))
    faults = faults_of(path, ["length=3 kN", "nonsense", "every=1 m"])
    assert [fault.override for fault in faults] == [None, "nonsense", "length=3 kN", "every=1 m"]


def test_an_override_mends_the_file(tmp_path):
    path = good_scenes.write(tmp_path, ROPE.replace('"60 m"', '"60 kN"'))
    assert load_study(path, ["length=60 m"]).scene.lines["rope"].length == 60.0


def test_too_many_runs(tmp_path):
    overrides = [
        f"{key}={list(range(1, 101))}" for key in ("length", "p2", "mass", "density", "gravity")
    ]
    faults = faults_of(good_scenes.write(tmp_path, ROPE.replace("[0.1, nan]", "[nan]")), overrides)
    assert any("expected at most 10000000 runs" in fault.message for fault in faults)


def test_faults_are_comparable_and_told_once():
    fault = Fault("a.toml", 3, "x", "expected y, found z")
    error = SceneError([fault, Fault("a.toml", 1, "", "first"), fault])
    assert [f.line for f in error.faults] == [1, 3]
    assert re.fullmatch(r"a.toml:1: first\na.toml:3: x: expected y, found z", str(error))


def test_scene_errors_survive_a_trip_between_processes(tmp_path):
    path = good_scenes.write(tmp_path, ROPE.replace("60 m", "60 kN"))
    with pytest.raises(SceneError) as caught:
        load_study(path)
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.faults == caught.value.faults
    assert str(again) == str(caught.value)


@pytest.mark.parametrize("junk", ["true", "[]", "[a, b]", "{a=1}", "1979-05-27", "[[1,2],[3]]"])
def test_nonsense_anywhere_is_told_and_never_a_crash(tmp_path, junk):
    path = good_scenes.write(tmp_path, ROPE)
    keys = [".".join(map(str, place)) for place, _ in paths(Spot(Scene, tomllib.loads(ROPE)))]
    assert len(keys) > 60
    told = []
    for key in keys:
        with suppress(SceneError), recording(told):
            load_study(path, [f"{key}={junk}"])
    assert len(told) > len(keys) / 2
    assert all(fault.message.startswith("expected ") for fault in told)


@contextmanager
def recording(told):
    try:
        yield
    except SceneError as error:
        told += error.faults
        raise


def test_read_scene_takes_tables_and_returns_a_scene_or_problems():
    data = tomllib.loads(ROPE)
    del data["sweep"]
    scene, problems = read_scene(data)
    assert scene is not None
    assert scene.lines["rope"].length == 60.0
    assert problems == []
    data["lines"]["rope"]["material"] = "hemp"
    scene, problems = read_scene(data)
    assert scene is None
    assert [problem.path for problem in problems] == [("lines", "rope", "material")]
