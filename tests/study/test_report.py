"""The table after a run: every number at its place at any width, nothing eaten on the way."""

import re
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from lumpedcable.scene import load_study
from lumpedcable.scene.outcomes import QUANTITIES, RESULTS, SUMMARIES, TAKEN
from lumpedcable.status import Status
from lumpedcable.study import report, tables
from lumpedcable.study.outcome import Outcome
from lumpedcable.study.rest_report import rest_table
from lumpedcable.study.run import run_study
from lumpedcable.study.summary import empty_table

SNAPBACK = Path(__file__).parents[2] / "configs" / "snapback.toml"
# quantity -> (what the runs have, how it is printed with its unit in the heading)
NUMBERS = {
    "static_strain": (0.29228, "0.2923"),
    "exact_static_strain": (0.31416, "0.3142"),
    "peak_end_speed": (212.754, "212.75"),
    "exact_peak_end_speed": (228.839, "228.84"),
    "end_displacement": (16.7082, "16.708"),
    "front_arrival": (0.061443, "61.44"),
    "exact_front_arrival": (0.058429, "58.43"),
}
HEADINGS = ["strain", "(-)", "peak end", "(m/s)", "placement", "(m)", "(ms)", "(%)", "status"]


def outcome(run, status=Status.OK, message="ok"):
    numbers = {name: value for name, (value, _) in NUMBERS.items()}
    return Outcome(run, status, np.nan, message, 100, 1e-5, 3.2e-4, 1e4, 1e-12, np.zeros(1),
                   {"rope.end": numbers})  # fmt: skip


def printed(monkeypatch, width, study, outcomes, target="out.h5"):
    monkeypatch.setattr(tables, "WIDE", width)
    with redirect_stdout(StringIO()) as out:
        report.results_table(study, Path(target), outcomes)
    return out.getvalue()


@pytest.mark.parametrize(
    ("width", "exact", "references"), [(200, True, True), (120, True, True), (80, False, False)]
)
def test_numbers_and_headings_are_whole_at_any_width(monkeypatch, width, exact, references):
    text = printed(monkeypatch, width, load_study(SNAPBACK), [outcome(run) for run in range(8)])
    assert "…" not in text
    assert all(len(line) <= width for line in text.splitlines())
    for heading in HEADINGS:
        assert heading in text
    rows = re.findall(r"^ +[0-7] +\d+ kN +\d+ ms .*$", text, re.MULTILINE)
    assert len(rows) == 8
    shown = {name for name in NUMBERS if exact or not name.startswith("exact_")}
    for row in rows:
        assert {name for name in NUMBERS if NUMBERS[name][1] in row.split()} == shown
    # the paper's displacements, in the order of the runs
    told = ["6.37", "7.57", "12.66", "12.86", "16.87", "16.87", "21.74", "20.74"]
    assert [value in row.split() for value, row in zip(told, rows, strict=True)] == [references] * 8
    assert ("A wider terminal shows exact values and references as well." in text) != references


@pytest.mark.parametrize("width", [70, 50, 30, 24])
def test_a_narrow_terminal_gets_fewer_columns_and_whole_numbers(monkeypatch, width):
    outcomes = [outcome(run) for run in range(8)]
    text = printed(monkeypatch, width, load_study(SNAPBACK), outcomes)
    assert "…" not in text
    assert all(len(line) <= width for line in text.splitlines() if not line.startswith("written"))
    rows = [line.split() for line in text.splitlines() if re.match(r" +[0-7] ", line)]
    assert len(rows) == 8
    whole = {told for name, (_, told) in NUMBERS.items() if not name.startswith("exact_")}
    left = [{word for word in row if "." in word and word != "0.000"} for row in rows]
    assert all(some <= whole for some in left)
    assert len(left[0]) < len(whole) or width == 70
    assert all(row[-1] == "ok" for row in rows)
    note = " ".join(text[text.index("A wider") : text.index("written")].split())
    hidden = {"strain", "peak end speed", "end displacement", "far end feels it"}
    assert sum(words in note for words in hidden) == len(whole) - len(left[0])
    assert "energy closure" in note


def test_columns_of_text_are_broken_between_words_before_numbers_go(monkeypatch):
    table = tables.table_of(("number", "found", "remark"), left=(0, 2), wrap=(0, 2))
    table.add_row("lines.rope.drag.tangential", "123.456 kN", "not told by the data")
    shown = {}
    for width in (60, 50, 44, 20):
        monkeypatch.setattr(tables, "WIDE", width)
        with redirect_stdout(StringIO()) as out:
            tables.console_of().print(table)
        shown[width] = out.getvalue()
        assert "…" not in shown[width]
    assert "not told by the data" not in shown[60]
    for width, there in ((60, True), (50, True), (44, True), (20, False)):
        assert ("123.456 kN" in shown[width]) is there
    for width, there in ((60, True), (50, True), (44, False), (20, False)):
        assert ("told" in shown[width]) is there
    assert "A wider terminal shows remark as well." in shown[44]
    assert "found and" in shown[20]


def test_exact_columns_are_there_where_something_exact_is_known(monkeypatch):
    # a material that relaxes has no exact wave: columns of dashes would tell nothing
    study = load_study(SNAPBACK.with_name("relaxing-rope.toml"))
    known = [outcome(run) for run in range(4)]
    own = {
        key: np.nan if key.startswith("exact_") else value for key, (value, _) in NUMBERS.items()
    }
    unknown = [replace(one, recoils={"rope.end": own}) for one in known]
    assert "exact" in printed(monkeypatch, 120, study, known)
    text = printed(monkeypatch, 120, study, unknown)
    assert "exact" not in text
    assert "212.75" in text
    assert "exact" not in printed(monkeypatch, 40, study, unknown)
    # of two that are swept, a branch is told from its material
    assert re.search(r"^ +nylon .*\n +fast ", text, re.MULTILINE)


def test_references_are_of_numbers_that_runs_have():
    units = {name: unit for name, (unit, _) in (QUANTITIES | SUMMARIES).items()}
    assert {name: unit or "1" for name, unit in RESULTS.items()}.items() <= units.items()
    assert RESULTS.keys() >= QUANTITIES.keys()


def test_no_measure_can_take_the_name_of_a_number_in_the_summary():
    bare = SimpleNamespace(measures={}, lines={})
    table = empty_table(
        SimpleNamespace(scene=bare, ends=(), exact=False, peaked=(), energy=False), 1
    )
    assert {path[8:] for path in table if path.startswith("summary/")} <= TAKEN


def test_measures_have_a_unit_in_which_they_are_short(monkeypatch):
    measures = {"h_d": SimpleNamespace(UNIT="m"), "pull": SimpleNamespace(UNIT="N")}
    study = load_study(SNAPBACK)
    scene = study.scene.model_copy(update={"measures": measures})
    numbers = {"h_d": 0.2, "pull": 111281.961}
    outcomes = [replace(outcome(0), measures=numbers), replace(outcome(1), measures={})]
    text = printed(monkeypatch, 200, replace(study, scene=scene), outcomes)
    heading, row = text[: text.index("─")], text[text.index("─") :].splitlines()[1]
    assert "(kN)" in heading
    assert "(m)" in heading
    assert {"0.200", "111.282"} <= set(row.split())


def test_references_of_measures_stand_beside_them(monkeypatch):
    told = replace(outcome(0), recoils={}, peak_tension=277154.0, measures={"peak": 273789.0})
    lowering = load_study(SNAPBACK.with_name("lowering.toml"))
    text = printed(monkeypatch, 120, lowering, [told])
    row = text[text.index("─") :].splitlines()[1].split()
    assert row[:4] == ["0", "277.154", "273.789", "273.550"]
    assert "spring: the closed form above." in text
    narrow = printed(monkeypatch, 40, lowering, [told])
    assert "273.550" not in narrow
    assert "references" in narrow


def test_where_nothing_parts_the_largest_tension_is_told(monkeypatch):
    whole = [replace(outcome(0), recoils={}, peak_tension=123456.0)]
    text = printed(monkeypatch, 120, load_study(SNAPBACK), whole)
    assert "(kN)" in text
    assert "123.456" in text.split("kN)")[1].split()
    assert "tension" not in printed(monkeypatch, 120, load_study(SNAPBACK), [outcome(0)]).split(
        "* exact"
    )[0].replace("pretension", "")


def test_references_say_what_they_belong_to(monkeypatch):
    told = "zhu2018: Zhu, Yin & Shen 2018, sections 3 and 4. "
    belongs = "These numbers belong to the scene without --set."
    outcomes = [outcome(run) for run in range(8)]
    text = printed(monkeypatch, 400, load_study(SNAPBACK), outcomes)
    assert told in text
    assert belongs not in text
    text = printed(monkeypatch, 400, load_study(SNAPBACK, ["rope.length=90 m"]), outcomes)
    assert re.search(f"^{told}.*{belongs}$", text, re.MULTILINE)


def test_words_in_brackets_are_words_not_markup(monkeypatch):
    study = load_study(SNAPBACK, ["title=Rope [/b] of [red]nylon[/red]"])
    failed = outcome(0, Status.NON_FINITE, "undefined at [bold]3 ms")
    text = printed(monkeypatch, 200, study, [failed], "[a]/x.h5")
    assert "Rope [/b] of [red]nylon[/red]" in text
    assert "run 0: undefined at [bold]3 ms" in text
    assert "non finite" in text
    assert text.endswith("written: [a]/x.h5\n")


def test_the_path_of_the_file_is_never_broken(monkeypatch):
    target = "a_long_folder_name/" * 12 + "x.h5"
    text = printed(monkeypatch, 80, load_study(SNAPBACK), [outcome(0)], target)
    assert text.endswith(f"written: {target}\n")


def test_a_large_study_is_cut_and_says_so(monkeypatch):
    pretensions = list(range(1000, 201_000, 1000))
    study = load_study(SNAPBACK, [f"pretension={pretensions}", "break.time=0"])
    outcomes = [outcome(run, Status.NON_FINITE, "undefined") for run in range(200)]
    text = printed(monkeypatch, 120, study, outcomes)
    assert "60 of 200 rows shown; the file holds all." in text
    assert len(re.findall(r"^runs 0 to 199: undefined$", text, re.MULTILINE)) == 1


def test_of_many_different_failures_the_first_are_told(monkeypatch):
    study = load_study(SNAPBACK, [f"pretension={list(range(1000, 201_000, 1000))}", "break.time=0"])
    outcomes = [outcome(run, Status.NON_FINITE, f"undefined at {run} ms") for run in range(200)]
    text = printed(monkeypatch, 120, study, outcomes)
    assert len(re.findall(r"^run \d+: undefined at \d+ ms$", text, re.MULTILINE)) == 10
    assert "and 190 more runs went wrong" in text


def test_which_end_broke_is_told_where_another_could_have(monkeypatch, tmp_path):
    text = SNAPBACK.read_text()
    study = load_study(SNAPBACK)
    assert "rope.end" not in printed(monkeypatch, 120, study, [outcome(0)])
    more = text[: text.index("[references")] if "[references" in text else text
    (tmp_path / "two.toml").write_text(
        more + '\n[events.other]\nbreaks = "rope@30 m"\ntime = "1 ms"\ntension = "1 MN"\n'
    )
    two = load_study(tmp_path / "two.toml")
    assert "rope.end" in printed(monkeypatch, 120, two, [outcome(0)])


HANGS = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "wire"
length = 10
segments = 4
mass = 2
start = { fixed = [0, 0, 0] }
end = "free"
[measures.pull]
tension = "rope.start"
[sweep]
"lines.rope.mass" = [2, 4]
[output]
"""


@pytest.mark.slow
def test_a_scene_at_rest_tells_its_measures(tmp_path):
    (tmp_path / "scene.toml").write_text(HANGS)
    study = load_study(tmp_path / "scene.toml")
    run_study(study, tmp_path / "rest.h5")
    with redirect_stdout(StringIO()) as out:
        rest_table(study, tmp_path / "rest.h5")
    text = out.getvalue()
    told = text[text.index("measures") :]
    assert "pull" in told
    assert "196.200" in told  # N, the weight of 20 kg
    assert "392.400" in told
