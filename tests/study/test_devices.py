"""A batch shared out over two host devices: both take part, and each run comes out the same."""

import os
import subprocess
import sys

import h5py
import numpy as np
from command_line import ROOT
from engine_runs import nylon_rope, study_of

from lumpedcable.study.run import run_study

# one number of steps for all: one batch of sixteen
SMALL = (
    nylon_rope(12, "4 ms").replace("45 kN", "180 kN")
    + """
[sweep]
"events.break.time" = { from = "1 ms", to = "4 ms", count = 16 }
[solver]
waves = "plain"
"""
)
CODE = """
import sys
import jax
from lumpedcable.scene import load_study
from lumpedcable.study import compiled, run, shrinking
seen = []
real = shrinking.advance_runs
def watched(*arguments):
    found = real(*arguments)
    leaf = found[0].numbers
    seen.append([len(s.data) for s in leaf.addressable_shards])
    return found
shrinking.advance_runs = watched
from pathlib import Path
run.run_study(load_study(sys.argv[1]), Path(sys.argv[2]))
print(jax.device_count(), seen[0])
"""


def test_two_devices_take_half_of_the_runs_each_and_change_nothing(tmp_path):
    run_study(study_of(tmp_path, SMALL), tmp_path / "one.h5")
    ran = subprocess.run(
        [sys.executable, "-c", CODE, str(tmp_path / "scene.toml"), str(tmp_path / "two.h5")],
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "XLA_FLAGS": os.environ["XLA_FLAGS"] + " --xla_force_host_platform_device_count=2",
        },
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split("\n")[0] == "2 [8, 8]"
    with h5py.File(tmp_path / "one.h5") as one, h5py.File(tmp_path / "two.h5") as two:
        assert np.all(one["status"][()] == 0)
        for name in ("lines/rope/velocity", "lines/rope/tension", "summary/rope.end/reach"):
            mine, other = one[name][()], two[name][()]
            assert np.all(np.isfinite(mine))
            # rounding may differ where a batch is cut: nothing else may
            np.testing.assert_allclose(other, mine, rtol=1e-11, atol=1e-11 * np.max(np.abs(mine)))
            print(name, np.array_equal(mine, other))
