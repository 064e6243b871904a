"""Makes tests/ importable, so that tests of several packages share their helpers."""

import gc
import importlib
import itertools
import os
import sys
from importlib import metadata
from pathlib import Path

import jax
import pytest

# one cache of compiled programs for all tests, and for the next time they run
CACHE = Path(__file__).parent.parent / ".pytest_cache" / "xla"
os.environ.setdefault("LUMPEDCABLE_CACHE", str(CACHE))
# Programs of the tests alone are compiled as those of the package are (`OLDER_WAY` there), in two thirds
# of the time. Quick tests compile more than they compute, so that they do without the effort of the last
# stage, in a fifth less; slow tests compile as users do. A jaxlib that does not know a flag would end
# the process: this one knows them.
first = "PYTEST_XDIST_WORKER" not in os.environ  # one that it starts finds the flags of the first
if first and metadata.version("jaxlib").startswith("0.10."):
    wanted = "--xla_cpu_use_fusion_emitters=false"
    if "slow" not in " ".join(sys.argv):
        wanted += " --xla_cpu_parallel_codegen_split_count=1 --xla_backend_optimization_level=0"
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {wanted}".strip()
# it sets jax up, before that is used for the first time: else what jax is told would depend on which
# tests run, and in which order
importlib.import_module("lumpedcable.study.compiled")
# tests replace functions, and would keep for others what these do
importlib.import_module("lumpedcable.study.kept").KEEPS = False
# what a machine takes to compile, beside whatever else it does, is not what tests are about
importlib.import_module("lumpedcable.study.progress").PATIENCE = 3600.0
gc.set_threshold(50_000, 50, 100)  # as the command line does: jax leaves little garbage

MAPS = Path("/proc/self/maps")
MOST_MAPS = 40_000
OFTEN = 10  # tests from one look at the maps to the next, which takes some 10 ms
counted = itertools.count(1)


@pytest.fixture(autouse=True, scope="session")
def _no_terminal():
    """All is printed as into a file, whatever terminal or service the tests are started from."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("COLUMNS", "FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
            patch.delenv(name, raising=False)
        yield


@pytest.fixture(autouse=True)
def _programs_are_let_go():
    """Drop compiled programs before there are too many.

    Each one holds memory maps, of which Linux grants a process 65 530; beyond, XLA dies of a
    segmentation fault. A user's process compiles a handful; a test process, thousands.
    """
    yield
    look = next(counted) % OFTEN == 0 and MAPS.exists()
    if look and MAPS.read_bytes().count(b"\n") > MOST_MAPS:
        jax.clear_caches()
        gc.collect()
