"""The pages agree with the code and with each other: tables, links, examples."""

import re
import runpy
import tomllib
from pathlib import Path

import pytest

from lumpedcable.physics import wave_terms as waves
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

ROOT = Path(__file__).parents[1]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]
PAGES = [path for path in PAGES if path.name != "gallery.md"]  # made by the build
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")

# what the pages say will be written, where output goes, and placeholders
PLANNED = {
    "solve/constrained.py",
    "physics/NAME.py",
    "physics/tension/NAME.py",
    "lumpedcable/physics/tension/cubic.py",
    ".pytest_cache/xla",
    "shards/000000.h5",
}
FOLDERS = ("", "lumpedcable", "docs")


def pages():
    return [pytest.param(path, id=path.name) for path in sorted(PAGES)]


def place_of(name):
    """A file that a page names, or None."""
    return next((ROOT / f / name for f in FOLDERS if (ROOT / f / name).exists()), None)


def anchors(text):
    """The anchors that a page's headings get on GitHub."""
    found = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in found}


def test_the_tables_of_the_language_are_those_of_the_code():
    script = runpy.run_path(str(ROOT / "docs" / "reference.py"))
    for path, least in zip(script["PAGES"], (20, 8), strict=True):
        page = path.read_text()
        assert (
            len(re.findall("<!-- (?:own )?keys of ", page))
            == len(script["BLOCK"].findall(page))
            >= least
        )
        assert script["filled"](page) == page, "run: python docs/reference.py"
    page = script["PAGE"].read_text()
    # an old table is found
    assert script["filled"](page.replace("| `length` |", "| `lenght` |")) == page


@pytest.mark.parametrize("path", pages())
def test_links_lead_somewhere(path):
    text = path.read_text()
    for target in LINK.findall(text):
        if re.match(r"https?://", target):
            continue
        file, _, anchor = target.partition("#")
        other = path.parent / file if file else path
        assert other.exists(), f"{path.name}: {target}"
        if anchor:
            assert anchor in anchors(other.read_text()), f"{path.name}: {target}"


@pytest.mark.parametrize("path", pages())
def test_files_that_are_named_exist(path):
    names = re.findall(r"`((?:[\w.-]+/)+[\w.-]*)`", path.read_text())
    names = [name for name in names if name not in PLANNED and not name.startswith("snapback")]
    assert [name for name in names if not place_of(name)] == []


@pytest.mark.parametrize("path", pages())
def test_what_is_in_a_file_is_in_it(path):
    text = path.read_text()
    for name, file in re.findall(r"`(\w+)` (?:of|in) `((?:\w+/)*\w+\.py)`", text):
        if file not in PLANNED:
            definition = rf"^ *(?:def |class )?{name}\b"
            assert re.search(definition, place_of(file).read_text(), re.MULTILINE), (name, file)


@pytest.mark.parametrize("path", pages())
def test_examples_are_toml(path):
    for block in re.findall(r"^```toml\n(.*?)^```", path.read_text(), re.DOTALL | re.MULTILINE):
        assert tomllib.loads(block)


@pytest.mark.parametrize("path", pages())
def test_nothing_is_left_to_do(path):
    assert not re.search(r"\b(TODO|FIXME|TBD|XXX)\b", path.read_text())


@pytest.mark.slow
def test_what_the_page_says_of_waves(tmp_path):
    page = (ROOT / "docs" / "model.md").read_text()
    told = f"b = {waves.LINEAR_VISCOSITY} c + {waves.QUADRATIC_VISCOSITY} |D|"
    assert told in page
    assert f"{waves.LINEAR_VISCOSITY}, {waves.QUADRATIC_VISCOSITY}, the limiter" in page
    changes = ["segments=400", "drag.tangential=0", "duration=50 ms", "every=0.1 ms",
               "break.time=[0, 5 ms]"]  # fmt: skip
    run_study(load_study(ROOT / "configs" / "snapback.toml", changes), tmp_path / "waves.h5")
    with open_result(tmp_path / "waves.h5") as result:
        numbers = result.summary()["rope.end"]
        exact = numbers["exact_peak_end_speed"]
        speed = -result.line("rope").velocity()[:, result.time >= 0.01, -1, 0]
    mean = abs(speed.mean(axis=1) / exact - 1.0).reshape(4, 2)
    peak = (numbers["peak_end_speed"] / exact - 1.0).reshape(4, 2)
    assert "is within 0.08 % of the exact" in page
    assert max(mean[:, 0]) < 0.0008
    assert "the peak is 5.0 % high at 45 kN" in page
    assert peak[0, 0] == pytest.approx(0.05, abs=0.002)
    assert "mean is within 0.1 % and the peak within 1 %" in page
    assert max(mean[:, 1]) < 0.001
    assert max(abs(peak[:, 1])) < 0.01


def test_pictures_are_small():
    pictures = [p for p in (ROOT / "docs" / "images").iterdir() if p.is_file()]
    assert pictures
    assert all(p.stat().st_size < 300_000 for p in pictures)


def test_the_verification_has_every_case_of_the_catalogue(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "catalogue"))
    from catalogue import CASES

    page = (ROOT / "docs" / "verification.md").read_text()
    rows = re.findall(r"^\| (.*?) \| (.*?) \| (\d+) \| ([\d.e-]+) \|", page, re.MULTILINE)
    assert [row[:3] for row in rows] == [
        (name, case.source, str(case.segments)) for name, case in CASES.items()
    ]
    # an error of the table is within what the tests hold the case to
    assert all(float(row[3]) <= 100.0 * CASES[row[0]].bound(CASES[row[0]].segments) for row in rows)


@pytest.mark.slow
def test_the_verification_is_of_today(monkeypatch):
    script = runpy.run_path(str(ROOT / "docs" / "verification.py"))
    from catalogue import CASES

    page = (ROOT / "docs" / "verification.md").read_text()
    for name, case in CASES.items():
        told = re.search(rf"^\| {re.escape(name)} \|.*$", page, re.MULTILINE)
        assert told is not None
        found = [cell.strip() for cell in script["row"](name, case).split("|")]
        for a, b in zip(told[0].split("|"), found, strict=True):
            number = re.fullmatch(r"[\d.e+-]+", b)
            assert (
                float(a) == pytest.approx(float(b), rel=0.1, abs=0.1) if number else a.strip() == b
            )


def test_the_first_page_starts_as_the_readme_does():
    block = re.compile(r"^```bash\n(.*?)^```", re.DOTALL | re.MULTILINE)
    first = [
        block.search(page.read_text()) for page in (ROOT / "README.md", ROOT / "docs/index.md")
    ]
    assert first[0] is not None
    assert first[1] is not None
    assert first[0][1] == first[1][1]
