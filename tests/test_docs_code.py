"""The documentation builds without a warning, and the code on its pages runs."""

import json
import re
import runpy
import shlex
import subprocess
import sys
import tomllib
from contextlib import chdir
from pathlib import Path

import matplotlib.image
import pytest
from command_line import say

from lumpedcable.cli import app
from lumpedcable.scene import load_study

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [path for path in sorted(DOCS.glob("*.md")) if path.name != "gallery.md"]
# meshes and a batch, four programs to compile; a design, which is one program a limit
LONG = {"tutorial-benchmark.md", "restraint.md"}
COMMANDS = {"tutorial-rope.md"}  # pages whose commands leave what their code reads
# code that reads a study of ten thousand runs, which is not made here; files of a changed package, which
# test_docs_extending.py makes
READ = {"studies.md", "extending.md"}
MADE = {"tutorial-snapback.md": ["end-speed.svg", "hawser.h5"], "tutorial-benchmark.md": ["mesh.svg"],
        "tutorial-rope.md": ["nylon-bench", "rope.svg"]}  # fmt: skip


def blocks(path, languages):
    """Languages and texts of the blocks of a page, in their order."""
    return re.findall(rf"^```({languages})\n(.*?)^```", path.read_text(), re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.name, marks=pytest.mark.slow if p.name in LONG else ())
        for p in PAGES
        if blocks(p, "python")
    ],
)
def test_the_code_of_a_page_runs(path, tmp_path):
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    names = {}
    with chdir(tmp_path):
        for language, block in blocks(path, "python|bash"):
            if language == "python":
                code = compile(block, path.name, "exec")
                if path.name not in READ:
                    exec(code, names)
            elif path.name in COMMANDS:
                assert say(tmp_path, *shlex.split(block)[1:]).code == 0
    made = [p.name for p in tmp_path.iterdir() if p.name != "configs"]
    assert sorted(made) == sorted(MADE.get(path.name, []))


def test_the_commands_of_the_pages_are_understood():
    found = 0
    for path in PAGES:
        for _, block in blocks(path, "bash"):
            for part in re.split(r"&&?|\n", block):
                words = shlex.split(part, comments=True)
                if words and Path(words[0]).name == "lumpedcable":
                    app.parse_args(words[1:], exit_on_error=False, print_error=False)
                    found += 1
    assert found > 8


def test_the_documentation_builds_without_a_warning(tmp_path):
    pytest.importorskip("furo", reason="the extra docs is not installed")
    pytest.importorskip("myst_nb", reason="the extra docs is not installed")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-d", tmp_path / "trees"]
    ran = subprocess.run(
        [*command, DOCS, tmp_path / "html"],
        env={"LUMPEDCABLE_GALLERY": "", "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    page = (tmp_path / "html" / "tutorial-snapback.html").read_text()
    assert "How far and how fast" in page
    assert "lumpedcable.api.run" in (tmp_path / "html" / "python.html").read_text()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("parting-line", marks=pytest.mark.slow),
        pytest.param("highline", marks=pytest.mark.slow),  # a minute of compiling
    ],
)
def test_a_notebook_says_what_it_said(name):
    pytest.importorskip("nbclient", reason="the extra docs is not installed")
    command = [sys.executable, DOCS / "notebooks.py", "--check", name]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def test_the_check_of_notebooks_finds_another_number():
    same = runpy.run_path(str(DOCS / "notebooks.py"))["same"]
    assert same("45 kN: 43.20 m/s", "45 kN: 43.21 m/s")
    assert not same("45 kN: 43.20 m/s", "45 kN: 43.30 m/s")
    assert not same("45 kN: ok", "45 kN: failed")


def test_all_notebooks_are_checked_and_have_their_outputs():
    kept = sorted((DOCS / "notebooks").glob("*.ipynb"))
    assert [path.stem for path in kept] == ["highline", "parting-line"]
    for path in kept:
        cells = [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"]
        counts = [cell["execution_count"] for cell in cells]
        assert counts == list(range(1, len(cells) + 1))
        assert not [o for cell in cells for o in cell["outputs"] if o["output_type"] == "error"]


def test_the_gallery_has_every_scene(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    gallery = runpy.run_path(str(DOCS / "gallery.py"))
    scenes = gallery["scenes"]()
    named = {p.relative_to(ROOT / "configs").with_suffix("").as_posix()
             for p in (ROOT / "configs").rglob("*.toml")}  # fmt: skip
    assert named == set(scenes)
    assert {*gallery["PICKED"], *gallery["LESS"]} <= named
    for name, path in scenes.items():
        if "lines" in tomllib.loads(path.read_text()):
            study = load_study(gallery["part_of"](path, tmp_path, name))
            assert len(study.runs) <= 500, f"{name}: too many runs for a picture"
    title, words = gallery["about"](scenes["snapback"])
    assert title == "Nylon line parting under water"
    assert words.startswith("A nylon mooring line parts under water: the eight runs of Zhu")
    # a picture is drawn once
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'gravity = 9.81\n[materials.m]\nlaw = "linear"\nEA = 1e4\n[lines.rope]\nmaterial = "m"\n'
        "length = 11.0\nsegments = 5\nmass = 1.0\nstart = { fixed = [0, 0, 0] }\n"
        "end = { fixed = [10, 0, 0] }\n[output]\nduration = 0.2\nevery = 0.1\n"
    )
    made = gallery["picture"](scene, tmp_path / "kept")
    assert matplotlib.image.imread(made).std() > 0.01
    first = made.stat().st_mtime_ns
    assert gallery["picture"](scene, tmp_path / "kept").stat().st_mtime_ns == first
