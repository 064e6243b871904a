"""Parts of the report on numbers made by hand: whole jobs, precision, and GPUs on paper."""

import jax
import numpy as np
import pytest

from benchmarks import __main__ as program
from benchmarks import gpu, jobs, on_paper, precision, speed_targets
from benchmarks.machine import UnableError
from lumpedcable.scene import load_study

FLOAT = jax.ShapeDtypeStruct((1000,), "float32")


def test_every_part_can_be_asked_for():
    assert {"precision", "jobs", "on-paper", "gpu"} <= set(program.parts())


# --- whole jobs ----------------------------------------------------------------------------------


def test_a_job_tells_its_time_memory_and_output():
    rows = [
        {"job": "a", "words": "`run a`", "runs": 8, "first": 6.0, "again": 2.0, "peak": 5e8,
         "written": 3e7},
        {"job": "b", "words": "`plot b`", "runs": 8, "first": 6.0, "again": None, "peak": 5e8,
         "written": 3e7},
    ]  # fmt: skip
    table = jobs.table({"rows": rows, "cores": 2}).splitlines()
    # 30 MB in 2 s
    assert table[2] == "| `run a` | 8 | 6.0 | 2.0 | 500 | 30 | 15 |"
    assert table[3] == "| `plot b` | 8 | 6.0 |  | 500 | 30 |  |"


@pytest.mark.parametrize("quick", [True, False])
def test_jobs_have_as_many_runs_as_they_say(quick):
    for job in jobs.jobs(quick):
        command, scene, *rest = job.command
        assert command in ("run", "study")
        assert len(load_study(scene, rest[1::2]).runs) == job.runs


def test_what_is_written_is_counted_whole(tmp_path):
    (tmp_path / "shards").mkdir()
    (tmp_path / "shards" / "0.h5").write_bytes(b"12345")
    (tmp_path / "study.h5").write_bytes(b"123")
    assert jobs.size(tmp_path) == 8
    assert jobs.size(tmp_path / "study.h5") == 3


@pytest.mark.slow
def test_a_job_is_watched(tmp_path):
    found = jobs.once(("run", "configs/snapback.toml", "--set", "lines.rope.segments=8"),
                      tmp_path / "out.h5", tmp_path / "cache")  # fmt: skip
    assert found["written"] == (tmp_path / "out.h5").stat().st_size
    # jax alone takes more than that, the limit is 1 GiB
    assert 1e8 < found["peak"] < 2**30


# --- precision -----------------------------------------------------------------------------------


def test_either_precision_has_a_row():
    errors = {"displacement": 0.01, "velocity": 0.02, "tension": 0.03, "tension_fine": 0.04,
              "front": 1e-3}  # fmt: skip
    points = [
        {"case": case, "segments": 100, "dtype": dtype, "warm": 1e-3, "steps": 7,
         "errors": errors | {"velocity": error}}
        for case in ("45 kN, 5 ms", "45 kN, at once")
        for dtype, error in (("float64", 0.02), ("float32", 0.05))
    ]  # fmt: skip
    head, _, *rows = precision.table({"points": points}).splitlines()
    assert head.startswith("| default, 45 kN | N | precision |")
    assert rows[0] == "| break 5 ms | 100 | float64 | 1 | 2 | 3 | 4 | +1.000 | 1 | 7 |"
    assert rows[1] == "| break 5 ms | 100 | float32 | 1 | 5 | 3 | 4 | +1.000 | 1 | 7 |"
    assert [row.split(" | ")[0] for row in rows[2:]] == 2 * ["| break at once"]


# --- on paper ------------------------------------------------------------------------------------


def test_operations_bytes_and_kernels_are_those_of_a_sum_by_hand():
    found = on_paper.counted(lambda x, y: x * y + y, (FLOAT, FLOAT))
    # one kernel: two operations an element, two numbers of four bytes read and one written
    assert found == (2000.0, 0.0, 12000.0, 1)
    assert on_paper.counted(lambda x: jax.numpy.tanh(x), (FLOAT,)).special == 1000.0


def test_a_step_does_what_the_scheme_in_c_does():
    source = (program.ROOT / "benchmarks" / "native" / "line.c").read_text()
    steps = source[source.index("static") : source.index("return peak")]
    # every + - * / < > and call of a function in its loops, and a few outside of them
    written = sum(steps.count(f" {sign} ") for sign in "+-*/<>")
    written += sum(steps.count(f"{name}(") for name in ("least", "most", "fabs", "sqrt", "tanh"))
    found = on_paper.counted(*on_paper.step(100))
    assert 0.5 * written < found.operations / 100 < 3.0 * written
    assert found.special / 100 == pytest.approx(3.0, abs=1.0)  # tanh and two roots
    # at the least displacement and velocity are read and written
    assert found.bytes / 100 >= 4 * 4


def test_limits_are_counts_over_peaks():
    data = {"operations": 200.0, "special": 3.0, "bytes": 335.0, "kernels": 10, "steps": 100,
            "nodes": 10}  # fmt: skip
    chip = on_paper.CHIPS[0]
    # 10^5 runs of 1000 node-steps: 10^8
    assert on_paper._memory(data, chip, 10**5) == pytest.approx(335e8 / 3.35e12)
    assert on_paper._arithmetic(data, chip, 10**5) == pytest.approx(200e8 / 67e12)
    # in batches of 100, 1000 of them, a thousand kernels each, 2 us
    assert on_paper._starts(100)(data, chip, 10**5) == pytest.approx(2.0)
    rows = on_paper.table(data).splitlines()
    assert len({row.count("|") for row in rows}) == 1
    assert "not measured" in rows[0]
    assert np.all(["s |" in row for row in rows[2:]])


# --- a GPU ---------------------------------------------------------------------------------------


def test_without_a_gpu_nothing_is_measured_of_one(monkeypatch):
    monkeypatch.setattr(gpu, "platform", lambda: "cpu")
    with pytest.raises(UnableError, match="no GPU"):
        gpu.run(quick=True)


def test_a_copy_reads_and_writes():
    assert 1e8 < gpu.bandwidth(2**22) < 1e13


def test_a_step_of_many_runs_does_as_much_as_they_do_alone():
    body, shapes = on_paper.traced(20, "float32")
    few, many = (gpu.counted(body, shapes, size) for size in (16, 64))
    assert many.operations == pytest.approx(4 * few.operations, rel=0.05)
    assert many.bytes == pytest.approx(4 * few.bytes, rel=0.05)
    assert 1 < many.kernels < 100


@pytest.mark.slow
def test_batches_go_through_their_time():
    (row,) = gpu.batches("float32", (2,))
    assert row["lanes"] == 2
    assert row["steps"] % (gpu.DURATION / gpu.EVERY) == 0
    assert row["seconds"] > 0.0


def studied(**changes):
    row = {
        "runs": 10**5,
        "dtype": "float32",
        "first": 15.0,
        "again": 10.0,
        "peak": 2e9,
        "failed": 0,
    }
    return {"studies": [row | changes, row | {"dtype": "float64", "first": 99.0}]}


def test_a_gpu_has_its_rows():
    batch = {"dtype": "float32", "lanes": 100, "seconds": 1e-3, "steps": 100, "nodes": 10,
             "operations": 2e5, "special": 0.0, "bytes": 1e5, "kernels": 7}  # fmt: skip
    points = [{"case": f"45 kN, {kind}", "segments": 100, "dtype": "float32", "warm": 1e-3, "steps": 7,
               "errors": dict.fromkeys(("displacement", "velocity", "tension", "tension_fine",
                                        "front"), 0.01)}
              for kind in ("5 ms", "at once")]  # fmt: skip
    told = gpu.table({"device": "a GPU", "bandwidth": 4e10, "batches": [batch], **studied(),
                      "errors": {"points": points}})  # fmt: skip
    # 10^5 node-steps in a ms, each of 100 bytes and 200 operations: 10 GB/s of 40, 20 GFLOP/s
    assert "| float32 | 100 | 1 | 10 | 100 | 7 | 100 | 0.01 | 25% | 200 | 0.02 |" in told
    assert "| 100000 runs, outputs each 1 ms | float32 | 15.0 | 10.0 | 10000 | 2000 | 0 |" in told


@pytest.mark.parametrize(
    ("changes", "met"),
    [({}, True), ({"first": 21.0}, False), ({"failed": 1}, False), ({"runs": 256}, False)],
)
def test_a_study_on_a_gpu_is_held_against_its_target(changes, met):
    *_, right = speed_targets._gpu(studied(**changes))
    assert right is met
    assert speed_targets._gpu(None)[-1] is None
