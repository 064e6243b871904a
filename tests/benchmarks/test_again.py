"""What is measured already: the pages have its tables, and it is written anew on any machine."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks import __main__ as program
from benchmarks import report
from benchmarks.machine import UnableError, sentence

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "docs" / "benchmarks"


def again(folder):
    command = [sys.executable, "-m", "benchmarks", "--again", "-o", folder]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_the_pages_have_the_tables_of_the_results():
    data = report.read(KEPT)
    assert data is not None
    found = report.tables(data)
    for file in program.PAGES:
        page = file.read_text()
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
    assert program.elsewhere(data | {"machine": data["parts"][name]["machine"]}, data)
    assert not program.elsewhere(data, data)


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


@pytest.fixture
def three_parts(monkeypatch):
    """A report of three parts, the second of which this machine lacks something for."""

    def lacks(quick, tell):
        raise UnableError("no tank")

    def measured(quick, tell):
        return {"data": [1.0], "table": "| 1 |"}

    mine = {"calm": measured, "waves": lacks, "wind": measured}
    monkeypatch.setattr(program, "parts", lambda: mine)
    monkeypatch.setattr(program.figures, "draw", lambda *given: [])
    monkeypatch.setattr(program.report, "tables", lambda data: {})


def test_a_part_that_cannot_be_measured_stops_no_other(three_parts, tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        program.main(["--all", "-o", str(tmp_path)])
    assert left.value.code == 2
    assert "waves could not be measured: no tank" in capsys.readouterr().err
    assert list(json.loads((tmp_path / "results.json").read_text())["parts"]) == ["calm", "wind"]


def test_without_names_every_part_is_measured(three_parts, tmp_path, capsys):
    program.main(["--quick", "-o", str(tmp_path)])
    kept = json.loads((tmp_path / "results.json").read_text())
    assert list(kept["parts"]) == ["calm", "wind"]
    assert kept["quick"] is True
    assert "waves could not be measured: no tank" in capsys.readouterr().out


def test_a_part_alone_that_cannot_be_measured_is_told(three_parts, tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        program.main(["waves", "-o", str(tmp_path)])
    assert left.value.code == 2
    assert "waves could not be measured: no tank" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["a file", "damaged results"])
def test_where_nothing_can_be_written_nothing_is_measured(three_parts, tmp_path, capsys, kind):
    there = tmp_path / "results.json"
    there.write_text("{", encoding="utf-8")
    with pytest.raises(SystemExit) as left:
        program.main(["calm", "-o", str(there if kind == "a file" else tmp_path)])
    assert left.value.code == 2
    assert "-o: expected" in capsys.readouterr().err
    assert there.read_text() == "{"


def test_a_part_without_its_packages_says_so(monkeypatch):
    def run(quick):
        raise ModuleNotFoundError("No module named 'towing'", name="towing")

    monkeypatch.setattr(
        program.importlib, "import_module", lambda name: SimpleNamespace(run=run, table=str)
    )
    part = program.guest("page")
    assert part is not None
    with pytest.raises(UnableError, match="no towing: pip install"):
        part(True, print)


def test_pages_are_not_filled_without_the_programs_that_they_compare_with(
    three_parts, monkeypatch, tmp_path, capsys
):
    monkeypatch.setattr(program, "absent", lambda machine: ["moordyn"])
    with pytest.raises(SystemExit):
        program.main(["calm", "--docs", "-o", str(tmp_path)])
    assert "found none of moordyn: pip install -e '.[bench]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_what_was_measured_here_is_kept_when_pages_of_another_machine_are_filled(
    three_parts, monkeypatch, tmp_path
):
    here, docs, page = tmp_path / "here", tmp_path / "docs", tmp_path / "page.md"
    page.write_text("")
    for name, of in (("PICTURES", docs), ("PAGE", page), ("PAGES", (page,))):
        monkeypatch.setattr(program, name, of)
    monkeypatch.setattr(program, "GUESTS", {"wind": "benchmarks.rods"})
    monkeypatch.setattr(program, "absent", lambda machine: [])
    mine = {"format": report.FORMAT, "machine": program.describe(), "quick": False}
    theirs = mine | {"machine": {"processor": "Abacus 3000"}}
    report.keep(mine | {"parts": {"calm": {"data": [7.0]}}}, here)
    report.keep(theirs | {"parts": {"calm": {"data": [8.0]}, "wind": {"data": [9.0]}}}, docs)
    program.main(["wind", "--docs", "-o", str(here)])
    for folder in (here, docs):
        kept = json.loads((folder / "results.json").read_text())
        assert kept["machine"] == mine["machine"]
        assert kept["parts"] == {"calm": {"data": [7.0]}, "wind": {"data": [1.0], "table": "| 1 |"}}
