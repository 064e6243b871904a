"""What happens when things go wrong: killed processes, full disks, wrong files, wrong callers."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import python

from lumpedcable.results import (
    OutputError,
    ResultError,
    ResultWriter,
    Variable,
    describe,
    open_result,
)
from lumpedcable.results.folder import StudyFolder
from lumpedcable.results.numbers import write_text

ROOT = Path(__file__).parents[2]

# a study in another process: 3 runs of 5 times, of which it writes a part and flushes
STUDY = """
    import os, sys, time
    import numpy as np
    from lumpedcable.results import Coordinate, ResultWriter, Variable
    writer = ResultWriter(
        sys.argv[1],
        dims={"run": 3, "time": 5, "lines/rope/node": 4, "xyz": 3},
        variables=[
            Variable("lines/rope/position", ("run", "time", "node", "xyz"), "f4", "m"),
            Variable("status", ("run",), "i1"),
            Variable("status_message", ("run",), "str"),
        ],
        coordinates={
            "time": Coordinate(np.arange(5) * 1e-3, "s", "time"),
            "lines/rope/unstretched_position": Coordinate(np.arange(4.0), "m", dims=("node",)),
        },
        attributes={"title": "killed", "solver": "leapfrog"},
    )
    writer.write("lines/rope/position", np.full((2, 2, 4, 3), 7.0), run=slice(0, 2),
                 time=slice(0, 2))
    writer.write("lines/rope/position", np.full((3, 4, 3), 7.0), run=0, time=slice(2, 5))
    writer.write("status_message", ["fine"], run=slice(0, 1))
    writer.flush()
"""


def script(text, *arguments):
    """A process of its own that runs a text; it does not outlive the block."""
    return python("-c", textwrap.dedent(text), *arguments)


@pytest.fixture
def small():
    return {
        "dims": {"run": 2, "time": 3},
        "variables": [Variable("energy/kinetic", ("run", "time"), "f8", "J")],
    }


def test_a_killed_process_leaves_what_it_flushed(tmp_path):
    target = tmp_path / "study.h5"
    # after the flush it goes on writing without end, so the kill falls between two writes
    loop = """
    print("ready", flush=True)
    while True:
        writer.write("lines/rope/position", np.full((5, 4, 3), 8.0), run=2)
    """
    with script(STUDY + loop, target) as process:
        assert process.stdout.readline() == "ready\n"
        with open_result(f"{target}.partial") as result:  # readable while it is being written
            assert not result.complete
        with pytest.raises(OutputError, match="another run is writing it"):
            ResultWriter(target, dims={"run": 1}, variables=[])
        process.kill()
        assert process.wait() == -signal.SIGKILL

    assert not target.exists()
    partial = tmp_path / "study.h5.partial"
    with open_result(partial) as result:
        assert not result.complete
        assert list(result.written) == [5, 2, 0]
        position = result.line("rope").position()
        np.testing.assert_array_equal(position[0], 7.0)
        np.testing.assert_array_equal(position[1, :2], 7.0)
        assert np.isnan(position[1, 2:]).all()
        assert result.status_message[0] == "fine"
    assert "incomplete: 1 of 3 runs written to the end, 1 up to 1 ms" in describe(partial)
    # a leftover is no obstacle to the next study
    with ResultWriter(target, dims={"run": 1, "time": 1}, variables=[]):
        pass
    assert target.exists()
    assert not partial.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="limits on file sizes are a Unix thing")
def test_a_full_disk_shows_before_anything_is_computed(tmp_path):
    text = """
    import resource, sys
    from lumpedcable.results import OutputError, ResultWriter, Variable
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
    try:
        ResultWriter(sys.argv[1], dims={"run": 1000, "time": 1000},
                     variables=[Variable("energy/kinetic", ("run", "time"))])
    except OutputError as error:
        print(error)
    """
    with script(text, tmp_path / "a.h5") as process:
        said, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert said.count("\n") == 1
    assert said.startswith(f"cannot write {tmp_path}/a.h5.partial: File too large")
    assert list(tmp_path.iterdir()) == []


FULL = """
    import os, sys
    import numpy as np
    from lumpedcable.results import OutputError, ResultWriter, Variable, disk
    create, stage = disk.create, sys.argv[2]
    def fill(file):  # every further write: no space left on device
        os.dup2(os.open("/dev/full", os.O_RDWR), file.id.get_vfd_handle())
        return file
    if stage == "laid out":
        disk.create = lambda path: fill(create(path))
    def study():
        variables = [Variable("energy/kinetic", ("run", "time")),
                     Variable("status_message", ("run",), "str")]
        with ResultWriter(sys.argv[1], dims={"run": 50, "time": 4}, variables=variables) as writer:
            writer.write("energy/kinetic", np.ones((50, 4)))
            if stage == "kept":
                writer.flush()
            fill(writer._file)
            writer.write("energy/kinetic", np.ones((50, 2)), time=slice(2, 4))
            writer.write("status_message", ["fine"] * 50)
    try:
        study()
    except OutputError as error:
        print(error)
"""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is Linux's")
@pytest.mark.parametrize("stage", ["laid out", "written", "kept"])
def test_a_disk_that_fills_up_is_told_and_the_process_goes_on(tmp_path, stage):
    script = [sys.executable, "-c", textwrap.dedent(FULL), str(tmp_path / "a.h5"), stage]
    ended = subprocess.run(
        script, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    told = f"cannot write {tmp_path}/a.h5.partial: No space left on device\n"
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, told, "")
    assert [p.name for p in tmp_path.iterdir()] == (["a.h5.partial"] if stage == "kept" else [])
    if stage == "kept":
        with open_result(tmp_path / "a.h5.partial") as result:
            assert not result.complete


def test_the_target_appears_only_when_finished(tmp_path, small):
    target = tmp_path / "new" / "folder" / "a.h5"
    writer = ResultWriter(target, **small)
    writer.write("energy/kinetic", np.ones((2, 3)))
    writer.flush()
    assert not target.exists()
    assert writer.finish(step=0.5) == target
    assert not writer.partial.exists()
    with open_result(target) as result:
        assert result.complete
        assert result.attributes["step"] == 0.5


def test_an_old_result_stays_until_the_new_one_is_finished(tmp_path, small):
    target = tmp_path / "a.h5"
    with ResultWriter(target, **small, attributes={"title": "old"}):
        pass
    writer = ResultWriter(target, **small, attributes={"title": "new"})
    with open_result(target) as result:
        assert result.attributes["title"] == "old"
    writer.finish()
    with open_result(target) as result:
        assert result.attributes["title"] == "new"


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
@pytest.mark.parametrize("there", [True, False])
def test_a_link_goes_on_leading_to_the_results(tmp_path, small, there):
    disk, link = tmp_path / "disk", tmp_path / "case.h5"
    disk.mkdir()
    link.symlink_to("disk/real.h5")
    if there:
        ResultWriter(disk / "real.h5", **small).finish()
    writer = ResultWriter(link, **small)
    writer.write("energy/kinetic", np.full((2, 3), 4.0))
    assert writer.partial.parent == disk
    writer.finish()
    assert os.readlink(link) == "disk/real.h5"
    assert [p.name for p in disk.iterdir()] == ["real.h5"]
    with open_result(link) as result:
        assert result.energy("kinetic", 0).tolist() == [4.0] * 3


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_links_to_other_files_and_to_folders_are_followed(tmp_path):
    page, study = tmp_path / "page.html", tmp_path / "study"
    page.symlink_to(tmp_path / "disk" / "real.html")
    study.symlink_to(tmp_path / "disk" / "real")
    (tmp_path / "disk").mkdir()
    write_text(page, "text")
    assert (tmp_path / "disk" / "real.html").read_text() == "text"
    StudyFolder.make(study, "", 4, 2, "1")
    assert StudyFolder.open(tmp_path / "disk" / "real").missing() == [0, 1]
    assert page.is_symlink()
    assert study.is_symlink()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["disk", "page.html", "study"]


def test_an_exception_before_a_flush_leaves_nothing(tmp_path, small):
    def study():
        with ResultWriter(tmp_path / "a.h5", **small) as writer:
            writer.write("energy/kinetic", np.ones((2, 3)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study()
    assert list(tmp_path.iterdir()) == []


def test_an_exception_after_a_flush_leaves_the_partial_file(tmp_path, small):
    def study():
        with ResultWriter(tmp_path / "a.h5", **small) as writer:
            writer.write("energy/kinetic", [[1.0, 2.0]], run=slice(0, 1), time=slice(0, 2))
            writer.flush()
            writer.write("energy/kinetic", [3.0], run=0, time=slice(2, 3))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study()
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5.partial"]
    with open_result(tmp_path / "a.h5.partial") as result:
        np.testing.assert_array_equal(result.energy("kinetic")[0], [1, 2, 3])
        assert list(result.written) == [3, 0]
    with pytest.raises(ResultError, match=r"unfinished a\.h5\.partial beside it"):
        open_result(tmp_path / "a.h5")


def test_abandoning_deletes_the_file(tmp_path, small):
    writer = ResultWriter(tmp_path / "a.h5", **small)
    writer.flush()
    writer.abandon()
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_written(tmp_path, small):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/a\.h5: (Not a directory|File exists)"):
        ResultWriter(tmp_path / "file" / "a.h5", **small)
    with pytest.raises(OutputError, match="it is a folder"):
        ResultWriter(tmp_path, **small)
    with pytest.raises(OutputError, match="it exists already"):
        ResultWriter(tmp_path / "file", **small, overwrite=False)
    assert (tmp_path / "file").read_text() == ""


@pytest.fixture
def nobody(tmp_path):
    """The test's folder closed to the test, who is not the superuser for as long."""
    superuser = os.geteuid() == 0
    tmp_path.chmod(0o500)
    if superuser:
        os.seteuid(65534)
    yield
    if superuser:
        os.seteuid(0)
    tmp_path.chmod(0o700)


@pytest.mark.skipif(sys.platform == "win32", reason="users and modes are Unix things")
@pytest.mark.usefixtures("nobody")
def test_a_forbidden_folder(tmp_path, small):
    with pytest.raises(OutputError, match=r"cannot write .*a\.h5(\.partial)?: Permission denied$"):
        ResultWriter(tmp_path / "a.h5", **small)


def test_files_that_are_no_results(tmp_path, small):
    with pytest.raises(ResultError, match="no such file"):
        open_result(tmp_path / "absent.h5")
    with pytest.raises(ResultError, match="is a folder"):
        open_result(tmp_path)
    (tmp_path / "text.h5").write_text("hello")
    with pytest.raises(ResultError, match="not an HDF5 file"):
        open_result(tmp_path / "text.h5")
    h5py.File(tmp_path / "other.h5", "w").close()
    with pytest.raises(ResultError, match="not a results file of lumpedcable"):
        open_result(tmp_path / "other.h5")
    with ResultWriter(tmp_path / "a.h5", **small):
        pass
    whole = (tmp_path / "a.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ResultError, match="damaged HDF5 file"):
        open_result(tmp_path / "cut.h5")
    for version, words in (("2", "newer than the 1 known here"), ("?", "unknown layout")):
        with h5py.File(tmp_path / "a.h5", "r+") as file:
            file.attrs["schema_version"] = version
        with pytest.raises(ResultError, match=words):
            open_result(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file.attrs["schema_version"] = "1"
        del file["time"]
    with pytest.raises(ResultError, match="no time"):
        open_result(tmp_path / "a.h5")


def test_messages_are_one_line(tmp_path):
    (tmp_path / "text.h5").write_text("hello")
    with pytest.raises(ResultError) as caught:
        open_result(tmp_path / "text.h5")
    assert "\n" not in str(caught.value)


def test_mistakes_of_the_calling_program(tmp_path, small):
    with ResultWriter(tmp_path / "a.h5", **small) as writer:
        with pytest.raises(ValueError, match=r"nearest: energy/kinetic"):
            writer.write("energy/kinetik", [1.0])
        with pytest.raises(ValueError, match=r"expected shape \(1, 3\), found \(1, 2\)"):
            writer.write("energy/kinetic", [[1.0, 2.0]], run=slice(0, 1))
        with pytest.raises(ValueError, match="not \\['node'\\]"):
            writer.write("energy/kinetic", [[1.0, 2.0]], node=0)
        with pytest.raises(ValueError, match=r"expected shape \(1, 2\), found \(2, 2\)"):
            writer.write("energy/kinetic", np.ones((2, 2)), run=slice(1, 3), time=slice(1, 3))
    with pytest.raises(ValueError, match="no dimension 'node'"):
        ResultWriter(tmp_path / "b.h5", dims={"run": 1}, variables=[Variable("v", ("node",))])
    with pytest.raises(ValueError, match="at least 1"):
        ResultWriter(tmp_path / "b.h5", dims={"run": 0}, variables=[])
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]
