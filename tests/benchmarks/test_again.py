"""What is measured already: the pages have its tables, and it is written anew on any machine."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import report
from benchmarks.__main__ import elsewhere
from benchmarks.machine import sentence

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "docs" / "benchmarks"


def again(folder):
    command = [sys.executable, "-m", "benchmarks", "--again", "-o", folder]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_the_pages_have_the_tables_of_the_results():
    data = report.read(KEPT)
    assert data is not None
    found = report.tables(data)
    for name in ("docs/benchmarks.md", "README.md"):
        page = (ROOT / name).read_text()
        names = [name for _, name, _ in report.BLOCK.findall(page)]
        assert names
        assert set(names) <= set(found)
        assert report.filled(page, found) == page
        # another number would be seen
        digit = page.index(".", page.index("<!-- benchmark"))
        wrong = page[:digit] + "5." + page[digit + 1 :]
        assert report.filled(wrong, found) == page


def test_a_table_of_another_machine_says_so():
    data = report.read(KEPT)
    assert data is not None
    mine = data["machine"]
    name = next(name for name, part in data["parts"].items() if "table" in part)
    data["parts"][name].pop("machine", None)
    assert mine["processor"] not in report.tables(data)[name]
    data["parts"][name]["machine"] = mine | {"processor": "Abacus 3000"}
    assert report.tables(data)[name].endswith(sentence(data["parts"][name]["machine"]))
    assert "Abacus 3000" not in report.tables(data)["machine"]
    assert elsewhere(data | {"machine": data["parts"][name]["machine"]}, data)
    assert not elsewhere(data, data)


@pytest.mark.slow
def test_results_of_another_machine_are_drawn(tmp_path):
    shutil.copy(KEPT / "results.json", tmp_path)
    ran = again(tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert json.loads((tmp_path / "results.json").read_text()) == json.loads(
        (KEPT / "results.json").read_text()
    )
    made = {path.stem for path in tmp_path.glob("*.svg")}
    assert {path.stem for path in KEPT.glob("*.svg")} <= made
    assert {"cost", "velocity-5-ms", "velocity-at-once"} <= made


@pytest.mark.slow
def test_without_results_there_is_nothing_to_write(tmp_path):
    ran = again(tmp_path)
    assert ran.returncode == 2
    assert f"expected results.json in {tmp_path}, found none" in ran.stderr
    assert "Traceback" not in ran.stderr
