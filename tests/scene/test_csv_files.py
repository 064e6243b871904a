"""CSV files as spreadsheets write them: units in headers, other separators, errors for numbers."""

from pathlib import Path

import good_scenes
import numpy as np
import pytest
from good_scenes import BRIDLE
from test_errors import faults_of
from test_ship_scenes import study

from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.columns import factor_of, places_of
from lumpedcable.scene.texts import FileError, named_file


def bridle(folder, **files):
    """The bridle with its table or its motion from other text."""
    path = good_scenes.write(folder, BRIDLE)
    for name, content in files.items():
        kind = "wb" if isinstance(content, bytes) else "w"
        with (folder / f"{name}.csv").open(kind) as file:
            file.write(content)
    return path


def only_fault(folder, **files):
    (fault,) = faults_of(bridle(folder, **files))
    return fault


# --- rows that begin with # ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("#N/A,0.5", 'number in column strain, found "#N/A" in tested.csv:3'),
        ("#DIV/0!,0.5", 'number in column strain, found "#DIV/0!" in tested.csv:3'),
        ("#REF!", 'number in column strain, found "#REF!" in tested.csv:3'),
        ("  #value!, 0.5", 'number in column strain, found "#value!" in tested.csv:3'),
        ("#WERT!,0.5", 'found "#WERT!" in tested.csv:3; a remark begins with # and a space'),
        ("####,0.5", 'found "####" in tested.csv:3'),
    ],
)
def test_a_row_that_begins_with_the_error_of_a_spreadsheet_is_no_remark(tmp_path, row, said):
    fault = only_fault(tmp_path, tested=f"strain,tension\n0,0\n{row}\n1,1\n")
    assert fault.key == "materials.tested.file"
    assert said in fault.message


@pytest.mark.parametrize(
    "row", ["# drift, 3", "#", "#0.5,700", "# 0.5,700", "#torn here", "#batch,7,8", "#a,b"]
)
def test_remarks_and_rows_taken_out_are_skipped(tmp_path, row):
    path = bridle(tmp_path, tested=f"#N°7, 2026\n# a, b\nstrain,tension\n0,0\n{row}\n1,1\n")
    assert load_study(path).scene.materials["tested"].strain == (0.0, 1.0)


@pytest.mark.parametrize("row", [",", ",,", " , ", "\t,"])
def test_rows_of_empty_cells_are_skipped(tmp_path, row):
    path = bridle(tmp_path, tested=f"strain,tension\n0,0\n{row}\n1,1\n{row}\n")
    assert load_study(path).scene.materials["tested"].strain == (0.0, 1.0)


@pytest.mark.parametrize("word", ["7,14138", "7,141", "1,000,000.5"])
def test_a_quoted_number_with_a_comma_gets_advice(tmp_path, word):
    fault = only_fault(tmp_path, tested=f'strain,tension\n0,0\n1,"{word}"\n')
    assert f'found "{word}" in tested.csv:3; write numbers with a decimal point' in fault.message


def test_an_error_in_a_column_that_nobody_reads_does_no_harm(tmp_path):
    path = bridle(tmp_path, tested="time,strain,tension\n#N/A,0,0\n#N/A,1,1\n")
    assert load_study(path).scene.materials["tested"].strain == (0.0, 1.0)


# --- separators ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t;x;y;z\n0;45;0;1\n", "found semicolons in tail.csv:1"),
        ("# a record\nt;x;y;z\n0;45,5;0;1\n", "found semicolons in tail.csv:2"),
        ("t\tx\ty\tz\n0\t45\t0\t1\n", "found tabs in tail.csv:1"),
        ('"t (s)";"x";"y";"z"\n0;45;0;1\n', "found semicolons in tail.csv:1"),
    ],
)
def test_other_separators_are_named(tmp_path, text, said):
    fault = only_fault(tmp_path, tail=text)
    assert fault.key == "lines.tail.end.motion.file"
    assert fault.message == (
        f"expected columns separated by commas, and numbers with a decimal point, {said}"
    )


def test_other_separators_are_named_of_a_ship_too(tmp_path):
    with pytest.raises(SceneError, match=r"with a decimal point, found tabs in rao\.csv:1"):
        study(tmp_path, rao="omega\theave\theave_phase\n0.4\t1\t0\n0.8\t1\t0\n")


# --- units -----------------------------------------------------------------------------------------


def test_columns_of_a_record_may_have_units_in_brackets(tmp_path):
    path = bridle(tmp_path, tail="t (min),x [mm],y (raw) (m),z\n0,45000,0,1\n1,45000,0.5,1\n")
    motion = load_study(path).scene.lines["tail"].end.motion
    assert motion.time == (0.0, 60.0)
    assert motion.position == ((45.0, 0.0, 1.0), (45.0, 0.5, 1.0))


def test_columns_of_a_table_may_have_units_in_brackets(tmp_path):
    path = bridle(tmp_path, tested="tension (kN),strain (%)\n0,0\n5,25\n")
    material = load_study(path).scene.materials["tested"]
    assert (material.strain, material.tension) == ((0.0, 0.25), (0.0, 5000.0))


def test_columns_of_ships_may_have_units_in_brackets(tmp_path):
    record = "t (ms),roll (deg),heave (cm)\n0,0,0\n1000,1,50\n2000,2,10\n"
    rao = "omega,heave (mm/m),heave_phase (deg)\n0.4,1000,0\n0.8,500,18\n"
    bodies = study(tmp_path, record=record, rao=rao).scene.bodies
    recorded, sea = bodies["receiver"].motion, bodies["third"].motion
    assert recorded.time == (0.0, 1.0, 2.0)
    np.testing.assert_allclose(recorded.heave, [0.0, 0.5, 0.1], rtol=1e-15)
    np.testing.assert_allclose(recorded.roll, [0.0, np.pi / 180, np.pi / 90], rtol=1e-15)
    np.testing.assert_allclose(sea.response["heave"], [[1, 0], [0.5, np.pi / 10]], rtol=1e-15)


def test_a_name_as_it_stands_goes_before_one_with_a_unit():
    assert places_of("x", ["x (ft)", "x"]) == [1]
    assert places_of("x", ["x (ft)", "x (m)"]) == [0, 1]


def test_a_unit_of_another_kind_is_told(tmp_path):
    fault = only_fault(tmp_path, tail="t (s),x (mm),y (kN),z\n0,45000,0,1\n1,45000,0,1\n")
    assert fault.message == (
        'expected a unit of a length (m), found "kN" for column y in tail.csv:1'
    )
    with pytest.raises(FileError, match='expected one unit in brackets, found "N" and "kN"'):
        factor_of("load (N) as (kN)", "N")


# --- names, order, encoding ------------------------------------------------------------------------


def test_a_header_in_capitals_is_told_what_to_write(tmp_path):
    fault = only_fault(tmp_path, tail="T,X (mm),Y,Z\n0,45,0,1\n")
    assert fault.message == (
        "expected the columns t, x, y, z, found T, X (mm), Y, Z in tail.csv:1; rename "
        '"T" to "t", "X (mm)" to "x (mm)", "Y" to "y", "Z" to "z"'
    )


def test_times_that_do_not_increase_are_told_with_their_line(tmp_path):
    fault = only_fault(tmp_path, tail="t,x,y,z\n0,45,0,1\n\n2,45,0,1\n1,45,0,1\n")
    assert fault.message == "expected times that increase, found 1 s after 2 s in tail.csv:5"
    fault = only_fault(tmp_path, tested="strain,tension\n0,0\n0.2,1\n0.2,2\n")
    assert fault.message.endswith("found 0.2 after 0.2 in tested.csv:4")


def test_a_file_without_a_name_is_one_fault(tmp_path):
    path = good_scenes.write(tmp_path, BRIDLE.replace('"tail.csv"', '""'))
    (fault,) = faults_of(path)
    assert fault.key == "lines.tail.end.motion.file"
    assert fault.message == 'expected the name of a file, found ""'


@pytest.mark.parametrize(
    ("content", "byte"),
    [
        ("t,x,y,z\n".encode("utf-16"), "0xff in line 1"),
        ("t,x,y,z\n# Länge\n".encode("latin-1"), "0xe4 in line 2"),
    ],
)
def test_other_encodings_are_told_what_to_do(tmp_path, content, byte):
    fault = only_fault(tmp_path, tail=content)
    assert fault.message == f"expected UTF-8 text, found byte {byte}; save it as UTF-8"


def test_a_file_may_lie_below_the_user_s_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert named_file(Path("elsewhere"), "~/m.csv") == tmp_path / "m.csv"
    assert named_file(Path("here"), "m.csv") == Path("here/m.csv")
