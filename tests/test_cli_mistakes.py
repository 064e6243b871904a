"""Mistakes on the command line: exit code 2, one clear message, and nothing left behind."""

import errno
import re
import sys
from pathlib import Path
from unittest import mock

import good_scenes
import h5py
import pytest
from command_line import SMALL, files, process, refused, say
from matplotlib.figure import Figure
from mistakes import MISTAKES, spoilt

from lumpedcable.results.target import check_folder


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with a results file of the small scene."""
    folder = tmp_path_factory.mktemp("results")
    good_scenes.write(folder, SMALL)
    assert say(folder, "run", "scene.toml").code == 0
    return folder


# --- mistakes in a scene -------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "edits", "key", "words", "at"), MISTAKES)
def test_a_mistake_in_a_scene(tmp_path, text, edits, key, words, at):
    bad = spoilt(text, edits)
    good_scenes.write(tmp_path, bad)
    line = bad[: bad.index(at)].count("\n") + 1
    told = refused(tmp_path, "run", "scene.toml", "-o", "out.h5")
    assert told.count("\n") == 1
    assert told.startswith(f"scene.toml:{line}: {key}{': ' if key else ''}expected ")
    for word in words:
        assert word in told


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("length=60 kN", "lines.rope.length: expected a positive length (m), found a force (N)"),
        ("length=-1", "lines.rope.length: expected a positive length (m), found -1"),
        ("segments=0", "lines.rope.segments: expected a whole number from 1 to 1000000, found 0"),
        ("mass=nan", "lines.rope.mass: expected a positive mass per length (kg/m), found nan"),
        ("pretension=600 kN", "expected at most 531.654 kN"),
        ("pretension=[1 kN, 600 kN]", "expected at most 531.654 kN"),
        ("solver.method=[heun, tsit5]", "solver.method: expected "),
        ("length=[5 m, , 6 m]", 'sweep."lines.rope.length".1: expected a positive length (m)'),
        ("length=[5 m,,]", 'sweep."lines.rope.length".1: expected a positive length (m)'),
        ("law=tahn", 'materials.nylon.law: expected law = "linear", "tanh"'),
        ("law=tahn", 'found "tahn"; did you mean "tanh"?'),
        ("lenght=50 m", 'found "lenght"; did you mean "lines.rope.length"?'),
        ("rope=3", "lines.rope: expected a table with material, length, mass, start, end, found 3"),
        ("nothing", 'expected KEY=VALUE, found "nothing"'),
        ("breaks=rope@70 m", "expected a place inside the line, between 0 m and 60 m"),
        ("convention=pi", 'expected "textbook", "half" or "projected", found "pi"'),
    ],
)
@pytest.mark.parametrize("command", ["run", "check"])
def test_a_mistake_in_an_override(tmp_path, command, change, words):
    good_scenes.write(tmp_path, SMALL)
    told = refused(tmp_path, command, "scene.toml", "--set", change)
    assert told.startswith(f"--set {change}: ")
    assert words in told


@pytest.mark.parametrize("command", ["run", "check", "study", "modes", "sensitivity", "view"])
def test_more_breaks_than_segments(tmp_path, command):
    good_scenes.write(tmp_path, SMALL)
    changes = ["--set", "segments=1", "--set", "breaks=rope@30 m"]
    told = refused(tmp_path, command, "scene.toml", *changes)
    line = SMALL[: SMALL.index("[lines.rope]")].count("\n") + 1
    assert told.startswith(f"scene.toml:{line}: lines: ")
    assert 'line "rope" has too few segments for its breaks along its length' in told


def test_only_a_result_that_is_none_is_the_fault_of_what_is_asked(tmp_path):
    good_scenes.write(tmp_path, SMALL)
    told = refused(tmp_path, "sensitivity", "scene.toml", "--of", "max tension at rop.end")
    assert told.startswith("--of: ")
    # gravity has no place in one dimension
    asked = ["--of", "max tension at rope.end", "--set", "dimensions=1"]
    told = refused(tmp_path, "sensitivity", "scene.toml", *asked)
    assert told.startswith("--set dimensions=1: dimensions: ")
    # nor is it what goes wrong while a right one is worked out
    broken = mock.patch("lumpedcable.fitting.sensitivity._slopes", side_effect=ValueError("shapes"))
    with broken, pytest.raises(ValueError, match="shapes"):
        say(tmp_path, "sensitivity", "scene.toml", "--of", "max tension at rope.end")


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ("mass=1e-30", "scene.toml:"),  # waves of 1e15 times their speed
        ("output={duration = 1e12, every = 1e11}", "--set output={"),
    ],
)
def test_derivatives_of_a_run_that_would_never_end(tmp_path, change, place):
    good_scenes.write(tmp_path, SMALL)
    told = refused(tmp_path, "sensitivity", "scene.toml", "--set", change)
    assert told.startswith(place)
    assert "output.duration: more steps are needed than may be taken" in told


# --- wrong files ---------------------------------------------------------------------------------

NO_SCENE = [
    ("no such file", "scen.toml", 'expected a file, found none at "scen.toml"; did you mean "sc'),
    ("a folder", ".", ".: expected a file, found a directory"),
    ("a file below a file", "scene.toml/x.toml", "expected a file"),
    ("a name too long", "x" * 5000, "File name too long"),
    ("a picture", "picture.toml", "expected UTF-8 text"),
    ("an empty file", "empty.toml", "empty.toml:1: expected a scene, found an empty file"),
]


@pytest.mark.parametrize(("path", "words"), [c[1:] for c in NO_SCENE], ids=[c[0] for c in NO_SCENE])
@pytest.mark.parametrize("command", ["run", "check"])
def test_what_is_no_scene(tmp_path, command, path, words):
    good_scenes.write(tmp_path, SMALL)
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\r\n\x1a\n\xff")
    (tmp_path / "empty.toml").touch()
    assert words in refused(tmp_path, command, path)


OUTPUTS = [
    ("below a file", "scene.toml/x.h5", "cannot write scene.toml/x.h5"),
    ("a folder", ".", "--output: expected a file name, found the folder ."),
    ("the scene itself", "./scene.toml", "--output: expected another file than the scene"),
    ("a name too long", "x" * 300 + ".h5", "File name too long"),
    pytest.param(
        "where nothing can be written", "/proc/x.h5", "cannot write /proc/x.h5",
        marks=pytest.mark.skipif(sys.platform != "linux", reason="/proc is Linux's"),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("_what", "path", "words"), OUTPUTS)
def test_results_that_cannot_be_written(tmp_path, _what, path, words):
    good_scenes.write(tmp_path, SMALL)
    told = refused(tmp_path, "run", "scene.toml", "-o", path)
    assert told.count("\n") == 1
    assert words in told


BY_COMMAND = {
    "run": (["scene.toml", "-o", "scene.toml/x.h5"], "lumpedcable.study.report.run_with_progress"),
    "run --plot": (["scene.toml", "-o", "taken.h5"], "lumpedcable.study.report.run_with_progress"),
    "modes": (["scene.toml", "-o", "scene.toml/x"], "lumpedcable.study.modes.find_modes"),
    "sensitivity": (["scene.toml", "-o", "scene.toml"], "lumpedcable.fits.study_sensitivity"),
    "fit": (["fit.toml", "-o", "scene.toml/x/y"], "lumpedcable.fitting.whole.fit_study"),
    "view": (["scene.h5", "-o", "scene.toml/x.html"], "lumpedcable.page.open.recorded"),
}
BENCH = """scene = "scene.toml"
[free]
"materials.nylon.p1" = {}
[experiments.bench]
material = "nylon"
file = "bench.csv"
strain = { column = "strain" }
tension = { column = "load" }
"""


@pytest.mark.parametrize("command", BY_COMMAND)
def test_a_folder_that_cannot_be_is_told_before_anything_is_computed(
    results, tmp_path, monkeypatch, command
):
    good_scenes.write(tmp_path, SMALL)
    (tmp_path / "fit.toml").write_text(BENCH)
    (tmp_path / "bench.csv").write_text("strain,load\n0.1,1e4\n0.2,3e4\n")
    (tmp_path / "scene.h5").write_bytes((results / "scene.h5").read_bytes())
    (tmp_path / "taken").touch()
    arguments, computing = BY_COMMAND[command]
    monkeypatch.setattr(computing, lambda *_, **__: pytest.fail("it was computed first"))
    told = refused(tmp_path, *command.split(), *arguments)
    way = "taken" if "--plot" in command else "scene.toml"
    assert f"expected a folder, found the file {way}" in told
    assert told.count("\n") == 1
    # one that is not there yet is no obstacle, nor is it made before there is anything to put into it
    check_folder(tmp_path / "some" / "where")
    assert not (tmp_path / "some").exists()


OTHERS = {
    "run": ["run", "scene.toml"],
    "view": ["view", "scene.h5"],
    "animate": ["animate", "scene.h5", "--seconds", "0.2"],
    **{to: ["export", "scene.h5", "--to", to] for to in ("vtkhdf", "gltf", "csv", "moordyn")},
}
ENDS = {"run": "h5", "view": "html", "animate": "gif", "vtkhdf": "vtkhdf", "gltf": "glb",
        "csv": "csv", "moordyn": "out"}  # fmt: skip


@pytest.mark.parametrize("what", OTHERS)
def test_a_file_of_somebody_else_is_not_replaced(results, tmp_path, what):
    good_scenes.write(tmp_path, SMALL)
    (tmp_path / "scene.h5").write_bytes((results / "scene.h5").read_bytes())
    command = [*OTHERS[what], "-o", f"mine.{ENDS[what]}"]
    mine = tmp_path / f"mine.{ENDS[what]}"
    h5py.File(tmp_path / "other.h5", "w").close()
    for others in (b"Chapter 1", (tmp_path / "other.h5").read_bytes()):
        mine.write_bytes(others)
        told = refused(tmp_path, *command)
        assert f"cannot write {mine.name}: expected a " in told
        assert "which is kept" in told
        assert told.count("\n") == 1
        assert mine.read_bytes() == others
    # an empty file is nobody's, and what the command itself has made is replaced
    mine.write_bytes(b"")
    for _ in range(2):
        assert say(tmp_path, *command).code == 0
    assert mine.stat().st_size > 0


def test_tables_of_lines_do_not_replace_those_of_somebody_else(results, tmp_path):
    (tmp_path / "scene.h5").write_bytes((results / "scene.h5").read_bytes())
    (tmp_path / "scene_Line1.out").write_text("Chapter 1")
    told = refused(tmp_path, "export", "scene.h5", "--to", "moordyn")
    assert "cannot write scene_Line1.out: expected a MoorDyn file" in told


def test_results_larger_than_the_disk(tmp_path):
    good_scenes.write(tmp_path, SMALL)
    # 2 runs of 4e6 times of 1e6 nodes and segments of 64 bytes
    changes = ["--set", "segments=1000000", "--set", "every=1 ns"]
    told = refused(tmp_path, "run", "scene.toml", *changes)
    assert re.search(r"cannot write scene.h5: the results take 512 TB, .* are free", told)


@pytest.mark.parametrize("command", ["plot", "info"])
@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("nothing.h5", "no such file: nothing.h5"),
        (".", "expected a results file"),
        ("/", "expected a results file"),
        ("scene.toml", "not an HDF5 file"),
        ("scene.toml/x.h5", "no such file"),
        ("cut.h5", "expected a results file"),
        ("other.h5", "HDF5 but not a results file of lumpedcable"),
    ],
)
def test_what_is_no_results_file(results, tmp_path, command, path, words):
    good_scenes.write(tmp_path, SMALL)
    (tmp_path / "cut.h5").write_bytes((results / "scene.h5").read_bytes()[:5000])
    h5py.File(tmp_path / "other.h5", "w").close()
    told = refused(tmp_path, command, path)
    assert words in told
    assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--format", "gif"], "cannot draw in the format 'gif', expected one of pdf, png, svg"),
        (["-o", "scene.toml"], "expected a folder for the pictures, found the file scene.toml"),
        (["--run", "2"], "scene.h5: expected a run from 0 to 1, found 2"),
        (["-o", "scene.toml/below"], "cannot make the folder scene.toml/below"),
    ],
)
def test_pictures_that_cannot_be_drawn(results, arguments, words):
    assert words in refused(results, "plot", "scene.h5", *arguments)


@pytest.mark.parametrize("reason", [OSError(errno.ENOSPC, "No space left"), MemoryError()])
def test_a_picture_is_there_whole_or_not_at_all(results, tmp_path, monkeypatch, reason):
    (tmp_path / "scene.h5").write_bytes((results / "scene.h5").read_bytes())
    assert say(tmp_path, "plot", "scene.h5").code == 0
    before = {path: path.read_bytes() for path in (tmp_path / "scene").iterdir()}

    def half(figure, path, **options):
        Path(path).write_bytes(b"half of a picture")
        raise reason

    monkeypatch.setattr(Figure, "savefig", half)
    told = refused(tmp_path, "plot", "scene.h5")
    assert "No space left" in told or "not enough memory" in told
    assert {path: path.read_bytes() for path in (tmp_path / "scene").iterdir()} == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["scene.toml", "--count", "0"], "--count: expected at least 1, found 0"),
        (["scene.toml", "--run", "2"], "--run: expected a run from 0 to 1, found 2"),
        (["scene.toml", "--set", "length=-1"], "lines.rope.length: expected a positive length"),
        (["scen.toml"], "expected a file, found none"),
        (["scene.toml", "-o", "scene.toml"], "scene.toml"),
        (["scene.toml", "--format", "gif"], "expected one of pdf, png, svg"),
    ],
)
def test_modes_that_cannot_be_found(tmp_path, arguments, words):
    good_scenes.write(tmp_path, SMALL)
    assert words in refused(tmp_path, "modes", *arguments)


# --- wrong words ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rnu", "scene.toml"], 'Did you mean "run"?'),
        (["scene.toml"], "Unknown command"),
        (["--nonsense"], '"--nonsense"'),
        (["run"], "SCENE"),
        (["run", "scene.toml", "other.toml"], "expected nothing more, found 'other.toml'"),
        (["run", "scene.toml", "--outptu", "x.h5"], "Unknown option: --outptu"),
        (["run", "scene.toml", "-o"], "-o requires an argument"),
        (["run", "scene.toml", "--set"], "--set"),
        (["run", "scene.toml", "--timings=maybe"], "--timings"),
        (["plot"], "RESULT"),
        (["info", "--verbose", "scene.h5"], "Unknown option: --verbose"),
        (["check"], "SCENE"),
        (["schema", "2020"], "expected nothing more, found '2020'"),
        (["modes", "scene.toml", "--count", "many"], "many"),
    ],
)
def test_words_that_are_no_command(tmp_path, arguments, words):
    good_scenes.write(tmp_path, SMALL)
    told = refused(tmp_path, *arguments)
    assert words in told
    assert "see lumpedcable --help" in told.lower()


# --- as a process of its own ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "scene.toml", "--set", "length=60 kN"], "expected a positive length (m)"),
        (["run", "nothing.toml"], "expected a file, found none"),
        (["run", "scene.toml", "-o", "scene.toml/x.h5"], "cannot write"),
        (["plot", "scene.toml"], "not an HDF5 file"),
        (["fly"], 'Unknown command "fly"'),
    ],
)
def test_mistakes_end_a_process_with_code_2(tmp_path, arguments, words):
    good_scenes.write(tmp_path, SMALL)
    before = files(tmp_path)
    with process(tmp_path, *arguments) as ended:
        out, err = ended.communicate(timeout=120)
    assert (ended.returncode, out) == (2, "")
    assert words in err
    assert "Traceback" not in err
    assert files(tmp_path) == before


# --- another kind of file ------------------------------------------------------------------------

FIT = (
    'scene = "scene.toml"\n[free]\n"materials.nylon.p1" = {}\n[experiments.bench]\nfile = "x.csv"\n'
)
ASKED = "fit.toml: expected a scene, found a fit file: give its scene (scene.toml), or "
KINDS = [
    *[(command, "fit.toml", ASKED) for command in
      ("run", "check", "study", "modes", "sensitivity", "view")],
    *[(command, "fit.toml", "expected a results file; lumpedcable run writes one from a scene")
      for command in ("plot", "info", "animate", "export")],
    ("fit", "scene.toml", "expected a fit file, found a scene: lumpedcable run scene.toml computes"),
    ("plot", "scene.toml", "expected a results file; lumpedcable run writes one from a scene"),
    *[(command, "scene.h5", "found a results file (HDF5): lumpedcable info, plot and view take it")
      for command in ("run", "sensitivity", "fit")],
    ("fit", "data.csv", "data.csv: expected a fit file (*.toml), found a file *.csv"),
    ("run", "fit.json", "fit.json: expected a scene (*.toml), found a file *.json"),
]  # fmt: skip


@pytest.mark.parametrize(("command", "path", "words"), KINDS)
def test_a_file_of_another_kind(results, tmp_path, command, path, words):
    good_scenes.write(tmp_path, SMALL)
    (tmp_path / "fit.toml").write_text(FIT)
    (tmp_path / "data.csv").write_text("strain (%),load (kN)\n1,2\n")
    (tmp_path / "fit.json").write_text('{"title": "a fit"}\n')
    (tmp_path / "scene.h5").write_bytes((results / "scene.h5").read_bytes())
    told = refused(tmp_path, command, path, *(["--to", "csv"] if command == "export" else []))
    assert words in told
    assert told.count("\n") == 1
