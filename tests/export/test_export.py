"""Exports, read by other programs' readers or by hand, hold the file's numbers."""

import csv
import os
import subprocess
import sys

import h5py
import numpy as np
import pytest
import synthetic_result
from command_line import ROOT, refused, say
from engine_runs import fixed, line_text, study_of
from exported import HALF, RUN

from lumpedcable.export import FORMATS, export_result
from lumpedcable.results import Coordinate, ResultWriter, Variable, open_result
from lumpedcable.study.run import run_study


def test_vtk_reads_it_step_by_step(file, fields, tmp_path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF", reason="vtk is not installed")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    (made,) = export_result(file, "vtkhdf", tmp_path / "r.vtkhdf", RUN)
    reader = vtk.vtkHDFReader()
    assert reader.CanReadFile(str(made))
    reader.SetFileName(str(made))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 201
    position, velocity, tension = fields
    for step in (0, 37, 200):
        reader.SetStep(step)
        reader.Update()
        grid = reader.GetOutput()
        assert reader.GetTimeValue() == pytest.approx(synthetic_result.TIMES[step])
        assert (grid.GetNumberOfPoints(), grid.GetNumberOfCells()) == (9, 8)
        assert np.allclose(vtk_to_numpy(grid.GetPoints().GetData()), position[step], rtol=1e-6)
        found = vtk_to_numpy(grid.GetPointData().GetArray("velocity"))
        assert np.allclose(found, velocity[step], rtol=1e-6)
        found = vtk_to_numpy(grid.GetCellData().GetArray("tension"))
        assert np.allclose(found, tension[step], rtol=1e-6)
        # segment j lies between nodes j and j + 1
        ends = [[grid.GetCell(j).GetPointId(k) for k in (0, 1)] for j in range(8)]
        assert ends == [[j, j + 1] for j in range(8)]


def test_csv_holds_all_histories_of_all_runs(file, tmp_path):
    (made,) = export_result(file, "csv", tmp_path / "r.csv")
    with made.open(newline="") as text:
        head, *rows = list(csv.reader(text))
    assert head[:4] == ["run", "lines.rope.end.held.pretension [N]", "events.break.time [s]",
                        "time [s]"]  # fmt: skip
    table = np.array(rows, float)
    assert table.shape == (8 * 201, len(head))
    with open_result(file) as result:
        kinetic = result.energy("kinetic")
    column = head.index("energy/kinetic [J]")
    assert (table[:, column].reshape(8, 201) == kinetic).all()
    assert (table[:, 1].reshape(8, 201)[:, 0] == np.repeat(synthetic_result.PRETENSIONS, 2)).all()
    assert len(export_result(file, "csv", tmp_path / "one.csv", RUN)) == 1
    assert (tmp_path / "one.csv").read_text().count("\n") == 202


def test_csv_holds_the_motion_of_bodies(tmp_path):
    place = np.arange(18.0).reshape(2, 3, 3)
    angles = 0.01 * place
    angular = ("run", "time", "angle")
    variables = [
        Variable("bodies/ship/position", ("run", "time", "xyz"), "f8", "m"),
        Variable("bodies/ship/attitude", angular, "f8", "rad"),
        Variable("bodies/ship/turning", angular, "f8", "rad/s"),
        Variable(
            "status", ("run",), "i1", "1", "", {"flag_values": [0, 4], "flag_meanings": "ok lost"}
        ),
        Variable("status_time", ("run",), "f8", "s"),
    ]
    with ResultWriter(
        tmp_path / "r.h5", dims={"run": 2, "time": 3, "xyz": 3, "angle": 3}, variables=variables,
        coordinates={"time": Coordinate([0.0, 1.0, 2.0], "s")}, attributes={},
    ) as writer:  # fmt: skip
        writer.write("bodies/ship/position", place)
        writer.write("bodies/ship/attitude", angles)
        writer.write("bodies/ship/turning", -angles)
        writer.write("status", [0, 4])
        writer.write("status_time", [np.nan, 2.0])
        path = writer.finish()
    (made,) = export_result(path, "csv", tmp_path / "r.csv")
    head, *rows = list(csv.reader(made.read_text().splitlines()))
    turns = [f"bodies/ship/{{}}/{way} [{{}}]" for way in ("roll", "pitch", "yaw")]
    assert head == [
        "run", "time [s]", *(f"bodies/ship/position/{k} [m]" for k in "xyz"),
        *(text.format("attitude", "rad") for text in turns),
        *(text.format("turning", "rad/s") for text in turns),
    ]  # fmt: skip
    place[1, 2] = np.nan  # it went wrong then
    expected = np.concatenate([place, 0.01 * place, -0.01 * place], axis=-1).reshape(6, 9)
    np.testing.assert_array_equal(np.array(rows, float)[:, 2:], expected)


def test_csv_holds_what_sums_up_each_run_where_no_histories_are(tmp_path):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4)
    with h5py.File(path, "r+") as file:
        for name in ("lines", "energy"):
            del file[name]
        file["status"][2] = 2
    (made,) = export_result(path, "csv", tmp_path / "r.csv")
    with made.open(newline="") as text:
        head, *rows = list(csv.reader(text))
    assert head[:5] == ["run", "lines.rope.end.held.pretension [N]", "events.break.time [s]",
                        "status", "summary/energy_closure [-]"]  # fmt: skip
    assert [row[0] for row in rows] == list("01234567")
    assert [row[3] for row in rows] == ["ok", "ok", "diverged", *["ok"] * 5]
    with open_result(path) as result:
        for end, numbers in result.summary().items():
            for name, values in numbers.items():
                key = f"summary/{name}" if end == "run" else f"summary/{end}/{name}"
                unit = result.summary_attributes(end, name)["units"].replace("1", "-")
                column = head.index(f"{key} [{unit}]")
                found = np.array([row[column] for row in rows], float)
                np.testing.assert_array_equal(found, values)
    export_result(path, "csv", tmp_path / "one.csv", RUN)
    assert (tmp_path / "one.csv").read_text().splitlines()[1:] == [",".join(rows[RUN])]


CASES = ["as built", "longer, tighter"]


@pytest.mark.parametrize("histories", [True, False])
def test_csv_names_the_case_of_each_run(tmp_path, histories):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4)
    plain = export_result(path, "csv", tmp_path / "plain.csv")[0].read_text()
    with h5py.File(path, "r+") as file:
        file["case"] = np.repeat(CASES, 4).astype(object)
        if not histories:
            del file["lines"], file["energy"]
    (made,) = export_result(path, "csv", tmp_path / "r.csv")
    head, *rows = list(csv.reader(made.read_text().splitlines()))
    assert head[:3] == ["run", "case", "lines.rope.end.held.pretension [N]"]
    times = 201 if histories else 1
    assert [row[0] for row in rows] == np.repeat(list("01234567"), times).tolist()
    assert [row[1] for row in rows] == np.repeat(CASES, 4 * times).tolist()
    if histories:  # all else is as it was
        assert [[row[0], *row[2:]] for row in rows] == list(csv.reader(plain.splitlines()))[1:]
    export_result(path, "csv", tmp_path / "r.csv", RUN + 1)  # which replaces its own
    assert (tmp_path / "r.csv").read_text().count(f'4,"{CASES[1]}",') == times


def test_moordyn_tables_have_its_channels(file, fields, tmp_path):
    main, line = export_result(file, "moordyn", tmp_path / "r.out", RUN)
    assert (main.name, line.name) == ("r.out", "r_Line1.out")
    position, _, tension = fields
    names, units = (text.split("\t") for text in main.read_text().splitlines()[:2])
    assert names == ["Time", "FairTen1", "AnchTen1"]
    assert units == ["(s)", "(N)", "(N)"]
    table = np.loadtxt(main, skiprows=2)
    assert np.allclose(
        table, np.column_stack([synthetic_result.TIMES, tension[:, [-1, 0]]]), rtol=1e-7
    )
    names = line.read_text().splitlines()[0].split("\t")
    table = np.loadtxt(line, skiprows=2)
    assert np.allclose(table[:, names.index("Node8px")], position[:, 8, 0], rtol=1e-7)
    assert np.allclose(table[:, names.index("Node4pz")], position[:, 4, 2], rtol=1e-7)
    assert np.allclose(table[:, names.index("Seg8Te")], tension[:, 7], rtol=1e-7)


@pytest.mark.slow
def test_lines_are_numbered_as_the_scene_has_them(tmp_path):
    # by name line10 would come before line2, and the parts of the one that breaks in the middle apart
    names = [f"line{k}" for k in range(1, 12)]
    text = '[materials.wire]\nlaw = "linear"\nEA = "1 MN"\n' + "".join(
        line_text(name, "wire", 10, 2, 1, fixed(0, k, 0), fixed(10.1, k, 0))
        for k, name in enumerate(names)
    )
    text += '[events.cut]\nbreaks = "line2@5 m"\ntime = "1 ms"\nstart = "1 ms"\n'
    text += '[output]\nduration = "2 ms"\nevery = "1 ms"\n'
    run_study(study_of(tmp_path, text), tmp_path / "r.h5")
    parts = ["line2-1", "line2-2"]
    with open_result(tmp_path / "r.h5") as result:
        assert result.lines == [names[0], *parts, *names[2:]]
    made = export_result(tmp_path / "r.h5", "moordyn", tmp_path / "r.out", 0)
    last = np.loadtxt(made[-1], skiprows=2)
    columns = made[-1].read_text().splitlines()[0].split("\t")
    assert made[-1].name == "r_Line12.out"
    assert np.all(last[:, columns.index("Node0py")] == 10)


def test_moordyn_tables_of_targets_with_a_dot_do_not_replace_each_other(file, tmp_path):
    made = [export_result(file, "moordyn", tmp_path / f"case.{run}", run)[1] for run in (0, RUN)]
    assert [path.name for path in made] == ["case.0_Line1.out", "case.3_Line1.out"]
    first, second = (np.loadtxt(path, skiprows=2) for path in made)
    assert not np.array_equal(first, second)


def test_tables_and_grids_read_nan_from_where_a_run_went_wrong(blown, file, tmp_path):
    with open_result(file) as result:
        kinetic = result.energy("kinetic")
        tension = result.line("rope").tension(RUN)[:, :8]
    (made,) = export_result(blown, "csv", tmp_path / "r.csv")
    head, *rows = list(csv.reader(made.read_text().splitlines()))
    found = np.array(rows, float)[:, head.index("energy/kinetic [J]")].reshape(8, 201)
    kinetic[RUN, HALF:] = np.nan
    np.testing.assert_array_equal(found, kinetic)
    main, line = export_result(blown, "moordyn", tmp_path / "r.out", RUN)
    for path in (main, line):
        table = np.loadtxt(path, skiprows=2)
        assert np.isfinite(table[:HALF]).all()
        assert np.isnan(table[HALF:, 1:]).all()
    (made,) = export_result(blown, "vtkhdf", tmp_path / "r.vtkhdf", RUN)
    with h5py.File(made) as grid:
        found = grid["VTKHDF/CellData/tension"][()].reshape(201, 8)
        points = grid["VTKHDF/Points"][()].reshape(201, 9, 3)
    np.testing.assert_allclose(found[:HALF], tension[:HALF], rtol=1e-6)
    assert np.isnan(found[HALF:]).all()
    assert np.isfinite(points[:HALF]).all()
    assert np.isnan(points[HALF:]).all()


def test_what_has_stopped_rests_in_exports(tmp_path):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, sag=1.0)
    with h5py.File(path, "r+") as changed:
        changed["summary/stop_time"] = np.full(8, 0.05)
        changed["summary/stop_time"].dims[0].attach_scale(changed["run"])
    export_result(path, "csv", tmp_path / "r.csv")
    assert "nan" not in (tmp_path / "r.csv").read_text()


@pytest.mark.parametrize("kind", FORMATS)
def test_the_command_writes_beside_the_results(file, tmp_path, kind):
    copy = tmp_path / "case.h5"
    copy.write_bytes(file.read_bytes())
    said = say(tmp_path, "export", "case.h5", "--to", kind, "--run", "1")
    suffix = FORMATS[kind].endings[0]
    assert (said.code, said.err) == (0, "")
    assert said.out.splitlines()[0] == f"case{suffix}"
    made = {p.name for p in tmp_path.iterdir()} - {"case.h5"}
    assert made == set(said.out.split())


def test_a_table_of_somebody_else_is_kept(file, tmp_path):
    (tmp_path / "r.h5").write_bytes(file.read_bytes())
    blind = synthetic_result.snapback(tmp_path / "s.h5", segments=4)
    with h5py.File(blind, "r+") as changed:
        for name in ("lines", "energy"):
            del changed[name]
    for text in ("run,date,who\n1,2026-01-02,me\n", "run,a\n0,1\n", "run,status,note\n", "run,",
                 "run,case\n0,a\n", "run,a [m],case,time [s]\n"):  # fmt: skip
        (tmp_path / "r.csv").write_text(text)
        said = refused(tmp_path, "export", "r.h5", "--to", "csv")
        assert "expected a CSV file to replace or no file, found another one" in said
    # its own it replaces
    for name in ("r.h5", "s.h5"):
        for _ in range(2):
            assert say(tmp_path, "export", name, "--to", "csv", "-o", "own.csv").code == 0


def test_what_cannot_be_exported_is_told(file, tmp_path):
    said = refused(tmp_path, "export", file, "--to", "vtk")
    assert "expected a format, one of vtkhdf, gltf, csv, moordyn, found 'vtk'" in said
    assert "expected a run from 0 to 7, found 8" in refused(
        tmp_path, "export", file, "--to", "gltf", "--run", "8"
    )
    assert "another file than the results" in refused(
        tmp_path, "export", file, "--to", "csv", "-o", file
    )
    assert "a name that ends in .glb (binary glTF), found text.gltf" in refused(
        tmp_path, "export", file, "--to", "gltf", "-o", "text.gltf"
    )
    assert not (tmp_path / "text.gltf").exists()
    assert "a name that ends in .vtkhdf (VTKHDF), found lines.CSV" in refused(
        tmp_path, "export", file, "--to", "vtkhdf", "-o", "lines.CSV"
    )
    assert "a name that ends in .csv" in refused(
        tmp_path, "export", file, "--to", "csv", "-o", "table.xlsx"
    )
    blind = synthetic_result.snapback(tmp_path / "b.h5", segments=4, fields=("tension",))
    told = refused(tmp_path, "export", blind, "--to", "vtkhdf")
    assert "no positions to export: an ideal cable has none" in told
    assert "output.quantities" in told


FULL = """
import resource, signal, sys
from lumpedcable.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop()),) * 2)
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits on file sizes are a Unix thing")
@pytest.mark.parametrize("room", [10, 5000])
def test_a_full_disk_is_told_in_one_line(file, tmp_path, room):
    options = ["export", str(file), "--to", "vtkhdf", "-o", "a.vtkhdf", str(room)]
    ended = subprocess.run(
        [sys.executable, "-c", FULL, *options], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), "LUMPEDCABLE_CACHE": "off"},
    )  # fmt: skip
    said = (ended.returncode, ended.stdout, ended.stderr)
    assert said == (2, "", "cannot write a.vtkhdf: File too large\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [["export", "--to", k] for k in ("vtkhdf", "gltf", "moordyn")]
                         + [["animate"]])  # fmt: skip
def test_a_run_that_never_began_is_told(file, tmp_path, command):
    (tmp_path / "case.h5").write_bytes(file.read_bytes())
    with h5py.File(tmp_path / "case.h5", "r+") as case:
        case["lines/rope/position"][2] = np.nan
        case["status_message"][2] = "no static equilibrium was found"
    said = refused(tmp_path, *command, "case.h5", "--run", "2")
    assert "run 2 has no positions to" in said
    assert "no static equilibrium was found" in said
    with h5py.File(tmp_path / "case.h5", "r+") as case:
        case["status_message"][2], case["status"][2] = "", 0
    # of a run that has said nothing, how it ended
    said = refused(tmp_path, *command, "case.h5", "--run", "2")
    assert said.rstrip().endswith(": pending")
