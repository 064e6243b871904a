"""The TOML on the pages is read as it stands: scenes and fits whole, parts of them within a scene."""

import re
import shutil
import tomllib
from pathlib import Path

import pytest

from lumpedcable.fitting.load import load_fit
from lumpedcable.scene import SceneError, load_study

ROOT = Path(__file__).parents[1]
CONFIGS = ROOT / "configs"
PAGES = {path.name: path for path in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]}

SNAPBACK = (CONFIGS / "snapback.toml").read_text().partition("[sweep]")[0]
TRANSFER = (CONFIGS / "highline" / "transfer.toml").read_text()
END = '\n[output]\nduration = "200 ms"\nevery = "1 ms"\n'
SWEPT = f"{SNAPBACK}[sweep]\n"
WIRE = 'gravity = 9.81\n[materials.wire]\nlaw = "linear"\nEA = "1 MN"\n'
# goes on after "[lines.cable]", as the page says
FLOATING = f"""
material = "wire"
length = "80 m"
segments = 4
mass = "5 kg/m"
diameter = "40 mm"
start = {{ fixed = ["100 m", 0, "1 m"] }}
[water]
density = 1025
{END}"""
# the same
HOISTED = f"""
material = "wire"
length = "20 m"
segments = 4
mass = "5 kg/m"
[bodies.load]
mass = "1 t"
[bodies.crane]
position = [0, 0, "10 m"]
motion.heave = {{ amplitude = "1 m", period = "8 s" }}
points = {{ tip = ["12 m", 0, "30 m"] }}
{END}"""
HIGHLINES = """
[bodies.cargo]
mass = "2 t"
[lines.highline]
material = "wire"
length = "60.1 m"
segments = 4
mass = "4 kg/m"
start = { fixed = [0, 9, 0] }
end = { fixed = [60, 9, 0] }
[lines.before]
material = "wire"
length = "28 m"
segments = 4
mass = "4 kg/m"
start = { fixed = [0, 0, 0] }
end = "cargo"
[lines.after]
material = "wire"
length = "34.5 m"
segments = 4
mass = "4 kg/m"
start = "cargo"
end = { fixed = [60, 0, -16] }
"""
HAWSER = """
[lines.hawser]
material = "wire"
length = "60.1 m"
segments = 4
mass = "4 kg/m"
start = { motion = { position = [0, 0, 0], velocity = [-1, 0, 0] } }
end = { fixed = [60, 0, 2] }
"""

ON_A_CHAIN = """
[lines.chain]
material = "wire"
length = "30 m"
segments = 4
mass = "20 kg/m"
diameter = "40 mm"
start = { fixed = [0, 0, "-25 m"] }
end = "buoy"
"""


def blocks(name):
    """The TOML of a page, in its order."""
    return re.findall(r"^```toml\n(.*?)^```", PAGES[name].read_text(), re.DOTALL | re.MULTILINE)


def transfer_with(block):
    """The transfer with another cargo."""
    text, count = re.subn(r"\[bodies\.cargo\]\n(?:.+\n)+", block, TRANSFER)
    assert count == 1
    return text


BUOY, CURRENT, DRUM, SHIP, WAVES, CARGO, OVERLOAD, TARGETS, *SWEEPS = blocks("scene-language.md")
SWEPT_ASIDE = FLOATING.replace("density = 1025\n", f"density = 1025\n{CURRENT}").replace(
    'diameter = "40 mm"', 'diameter = "40 mm"\ndrag = { normal = 1.2, tangential = 0.01 }'
)
# the scene of each part, and its runs
WITHIN = {
    "a buoy": (f"{WIRE}{BUOY}{ON_A_CHAIN}{END}", 1),
    "a current": (f"{WIRE}{SHIP}{SWEPT_ASIDE}", 1),
    "a drum": (f"{WIRE}{DRUM}{HOISTED}", 1),
    "a ship": (f"{WIRE}{SHIP}{FLOATING}", 1),
    "waves": (f"{WIRE}{SHIP}{FLOATING}{WAVES}", 1),
    "cargo": (transfer_with(CARGO), 175),
    "an overload": (f"{WIRE}{HAWSER}{OVERLOAD}{END}", 1),
    "targets": (f"{WIRE}{HIGHLINES}{TARGETS}[output]\n", 1),
    "lists": (f"{SNAPBACK}{SWEEPS[0]}{END}", 4),
    "ranges": (f"{SWEPT}{SWEEPS[1]}{END}", 25),
    "together": (f"{SNAPBACK}{SWEEPS[2]}{END}", 3),
    "cases": (f"{SNAPBACK}{SWEEPS[3]}{END}", 2),
    "draws": (f"{SNAPBACK}{SWEEPS[4]}{END}", 1024),
}


@pytest.mark.parametrize("name", WITHIN)
def test_a_part_of_a_scene_is_read(name, tmp_path):
    text, runs = WITHIN[name]
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert len(load_study(path).runs) == runs


def test_a_key_that_is_not_there_is_found(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(WITHIN["a ship"][0].replace("above_keel", "above_kel"))
    with pytest.raises(SceneError, match="above_keel"):
        load_study(path)


@pytest.fixture
def fits(tmp_path):
    """A folder for fit files, beside a scene as the examples are, with records of two coils."""
    shutil.copytree(CONFIGS / "fit", tmp_path / "fit")
    shutil.copy(CONFIGS / "snapback.toml", tmp_path)
    (tmp_path / "fit" / "coils").mkdir()
    for coil in ("A12", "A13"):
        shutil.copy(CONFIGS / "fit" / "bench.csv", tmp_path / "fit" / "coils" / f"{coil}.csv")
    return tmp_path / "fit"


WHOLE = [block for block in blocks("fitting.md") if block.startswith("scene = ")]
COILS = [block for block in blocks("fitting.md") if not block.startswith("scene = ")]


@pytest.mark.parametrize("block", [*WHOLE, *blocks("tutorial-rope.md")])
def test_a_fit_is_read(block, fits):
    path = fits / "one.toml"
    path.write_text(block)
    assert load_fit(path).problem is not None


def test_the_fit_of_many_ropes_is_read(fits):
    (block,) = COILS
    (columns,) = [b for b in blocks("tutorial-rope.md") if "strain = " in b]
    columns = columns[columns.index("strain = ") :]
    path = fits / "many.toml"
    path.write_text(
        f'scene = "../snapback.toml"\n{block}{columns}\n[free]\n"materials.nylon.p1" = {{}}\n'
    )
    assert list(load_fit(path).ropes) == ["A12", "A13"]
    path.write_text(path.read_text().replace('ropes = "*" ', 'ropes = ["A12", "A13"] '))
    assert list(load_fit(path).ropes) == ["A12", "A13"]


def test_the_fit_of_the_tutorial_is_the_one_that_it_runs():
    (block,) = blocks("tutorial-rope.md")
    told, kept = (
        tomllib.loads(text) for text in (block, (CONFIGS / "fit" / "nylon-bench.toml").read_text())
    )
    first = {key: kept["free"][key] for key in told["free"]}
    assert told == kept | {"free": first}


@pytest.mark.parametrize("block", blocks("studies.md"))
def test_what_studies_keep_is_read(block, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(SNAPBACK.partition("[output]")[0] + block)
    assert load_study(scene).runs[0].output.fields_after == 20


def test_no_page_has_others():
    # the scene of extending.md is run by test_docs_extending.py
    known = {"fitting.md", "scene-language.md", "studies.md", "tutorial-rope.md", "extending.md"}
    assert {name for name in PAGES if blocks(name)} == known
    assert len(SWEEPS) == 5
    assert len(COILS) == 1
