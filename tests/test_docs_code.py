"""The documentation builds without a warning, and the code on its pages runs."""

import json
import os
import re
import runpy
import shlex
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from contextlib import chdir, suppress
from pathlib import Path

import matplotlib.image
import pytest

from lumpedcable.cli import app
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.batches import SHARDS
from lumpedcable.view import maps

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [
    path for path in sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md")]) if path.name != "gallery.md"
]
# test_docs_extending.py applies the first, whole, and runs it; the second begins as the README, which
# test_docs.py holds it to
ELSEWHERE = {"extending.md", "index.md"}
INSTALL = (
    "python3 -m venv --without-pip .venv && python3 -m pip --python .venv/bin/python install -q "
)
# what is not run; the rest of its block is
LEFT_OUT = (
    # from the network; `.ci/run` does the second as it stands, which is these tests
    f"{INSTALL}. && ",
    f"{INSTALL}-e '.[test]' && .venv/bin/python -m pytest -n 2 --dist worksteal\n",
    # the same, and it puts a hook into the repository
    f"{INSTALL}-e '.[test,dev]' && . .venv/bin/activate && pre-commit install\n",
    # somebody's cluster; the last block of that page has a scheduler of its own
    "lumpedcable study scene.toml -o folder --executor dask --scheduler tcp://login1:8786 ",
)
# what stays behind
MADE = {
    "moordyn.md": ["spread-mooring.toml", "spread.h5"],
    "README.md": ["snapback", "snapback.h5"],
    "fitting.md": ["nylon-both", "snapback"],
    "highline.md": ["delivery", "delivery.h5"],
    "restraint.md": ["elastic.h5", "envelope", "restraint.h5"],
    "studies.md": ["lumpedcable-cache", "map", "scene.h5"],
    "transfer.md": ["chances.h5", "classes", "classes.h5", "transfer.h5"],
    "tutorial-benchmark.md": ["build", "mesh.svg"],
    "tutorial-rope.md": ["nylon-bench", "rope.svg"],
    "tutorial-snapback.md": ["end-speed.svg", "hawser.h5"],
    "view.md": [
        "page.html",
        "snapback.gif",
        "snapback.h5",
        "snapback.vtkhdf",
        "three-lines",
        "three-lines.h5",
    ],
}
# "scene.toml" of the page about studies: runs for two shards
SCENE = """
gravity = 9.81
[materials.m]
law = "linear"
EA = 1e5
[lines.rope]
material = "m"
length = 10.5
segments = 5
mass = 1.0
start = { fixed = [0, 0, 0] }
end = { fixed = [10, 0, 0] }
[sweep]
"lines.rope.length" = { from = 10.1, to = 10.9, count = 1100 }
[output]
duration = 0.02
every = 0.01
keep = "summaries"
"""
# a browser that reads the page and then presses Ctrl-C
BROWSER = """
import os, signal, sys, urllib.request
page = urllib.request.urlopen(sys.argv[1]).read().decode()
with open(sys.argv[0] + ".seen", "a") as seen:
    seen.write("page\\n" if "</title>" in page and len(page) > 500_000 else "nothing\\n")
os.kill(os.getppid(), signal.SIGINT)
"""


def blocks(path, languages):
    """Languages and texts of the blocks of a page, in their order."""
    return re.findall(rf"^```({languages})\n(.*?)^```", path.read_text(), re.DOTALL | re.MULTILINE)


def is_slow(path):
    """Whether what a page runs takes long: what a shell runs, and a page of many runs."""
    return bool(blocks(path, "bash")) or path.name == "python.md"


def runnable(path):
    """The blocks of a page without what cannot be run here."""
    found = []
    for language, block in blocks(path, "python|bash"):
        for fragment in LEFT_OUT:
            block = block.replace(fragment, "")
        if block.strip():
            found.append((language, block))
    return found


def put(folder):
    """The folder as a reader has it, of the largest sweeps parts; returns the environment."""
    here = Path(sys.executable).parent
    tools = folder / ".tools"
    tools.mkdir()
    (folder / ".venv").symlink_to(here.parent)
    hidden = shutil.ignore_patterns("_build", "build", "gallery*", "__pycache__")
    for name in ("configs", "docs", "benchmarks"):
        shutil.copytree(ROOT / name, folder / name, ignore=hidden)
    gallery = runpy.run_path(str(DOCS / "gallery.py"))
    for name in gallery["LESS"]:
        path = folder / "configs" / f"{name}.toml"
        gallery["part_of"](path, path.parent, name)
    (folder / "scene.toml").write_text(SCENE)
    (tools / "browser.py").write_text(BROWSER)
    # of SLURM: a task of an array, and what starts a job's processes
    (tools / "srun").write_text('#!/bin/sh\nexec "$@"\n')
    (tools / "srun").chmod(0o755)
    return {
        **os.environ,
        "PATH": f"{tools}:{here}:{os.environ['PATH']}",
        "BROWSER": f"{sys.executable} {tools / 'browser.py'} %s &",
        "SCRATCH": str(folder),
        "SLURM_ARRAY_TASK_COUNT": "200",
    }


def run_block(block, folder, env):
    """Run a block as it stands. What it leaves running is waited for; of a job, ended with it."""
    job = block.startswith("#!")
    log = folder / ".tools" / "log"
    with log.open("w") as said:
        process = subprocess.Popen(
            ["bash", "-euo", "pipefail", "-c", block if job else f"trap wait EXIT\n{block}"],
            cwd=folder, env=env, stdout=said, stderr=said, start_new_session=True,
        )  # fmt: skip
        try:
            code = process.wait(timeout=1200)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
                for _ in range(300):  # they tidy up behind them
                    process.poll()  # or it would be there until somebody asks how it ended
                    os.killpg(process.pid, 0)
                    time.sleep(0.1)
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert code == 0, log.read_text()


def run_commands(block, folder, env):
    """Run a block, an array job's as all of the tasks that have something to do."""
    tasks = [str(k + 1) for k in range(SHARDS)]  # a small study has no more shards
    for task in tasks if "SLURM_ARRAY_TASK_ID" in block else ("",):
        run_block(block, folder, {**env, "SLURM_ARRAY_TASK_ID": task})
    for name in ("folder", "study"):  # each block begins a study of its own
        if (folder / name).exists():
            with open_result(folder / name) as result:
                assert set(result.status) == {"ok"}
            shutil.rmtree(folder / name)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.name, marks=pytest.mark.slow if is_slow(p) else ())
        for p in PAGES
        if runnable(p) and p.name not in ELSEWHERE
    ],
)
def test_the_code_of_a_page_runs(path, tmp_path):
    env = put(tmp_path)
    before = {p.name for p in tmp_path.iterdir()}
    names = {}
    for language, block in runnable(path):
        if "python -m benchmarks" in block:
            pytest.importorskip("moordyn", reason="the extra bench is not installed")
        if language == "bash":
            run_commands(block, tmp_path, env)
        else:
            with chdir(tmp_path):
                exec(compile(block, path.name, "exec"), names)
    made = {p.name for p in tmp_path.iterdir()} - before
    assert sorted(made) == sorted(MADE.get(path.name, []))
    if path.name == "README.md":
        assert len(list((tmp_path / "snapback").glob("*.png"))) == 12  # "twelve pictures"
    opened = [b for _, b in blocks(path, "bash") for line in b.splitlines()
              if line.startswith("lumpedcable view") and " -o " not in line]  # fmt: skip
    seen = tmp_path / ".tools" / "browser.py.seen"
    assert (seen.read_text() if seen.exists() else "") == "page\n" * len(opened)


def test_what_is_not_run_is_on_the_pages():
    everything = "".join(block for path in PAGES for _, block in blocks(path, "bash"))
    assert all(fragment in everything for fragment in LEFT_OUT)


def test_every_block_is_of_a_kind_that_is_looked_at():
    # "": a drawing of the layers; {...}: Sphinx builds them; toml: test_docs_toml.py;
    # diff: test_docs_extending.py
    for path in PAGES:
        kinds = set(
            re.findall(r"^ *```(\S*)[^\n]*\n.*?^ *```", path.read_text(), re.DOTALL | re.MULTILINE)
        )
        assert {kind for kind in kinds if not kind.startswith("{")} <= {
            "",
            "bash",
            "python",
            "toml",
            "diff",
        }
        assert "" not in kinds or path.name == "architecture.md"
        assert "diff" not in kinds or path.name == "extending.md"


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


@pytest.mark.slow
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
        "parting-line",
        "highline",
    ],
)
@pytest.mark.slow
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
            if study.scene.output.keep == "summaries":  # its picture is a map, which must be filled
                assert len(study.runs) >= maps.ENOUGH, f"{name}: too few runs for a map"
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
