"""Makes tests/ importable, so that tests of several packages share their helpers."""

import gc
import importlib
import itertools
import os
from importlib import metadata
from pathlib import Path

import jax
import pytest

# one cache of compiled programs for all tests, and for the next time they run
CACHE = Path(__file__).parent.parent / ".pytest_cache" / "xla"
os.environ.setdefault("LUMPEDCABLE_CACHE", str(CACHE))
# Programs of the tests alone are compiled as those of the package are (`OLDER_WAY` there), in two thirds
# of the time. A jaxlib that does not know the flag would end the process: this one does.
if metadata.version("jaxlib").startswith("0.10."):
    flags = os.environ.get("XLA_FLAGS", "")
    os.environ["XLA_FLAGS"] = f"{flags} --xla_cpu_use_fusion_emitters=false".strip()
# it sets jax up, before that is used for the first time: else what jax is told would depend on which
# tests run, and in which order
importlib.import_module("lumpedcable.study.compiled")
gc.set_threshold(50_000, 50, 100)  # as the command line does: jax leaves little garbage

MAPS = Path("/proc/self/maps")
MOST_MAPS = 20_000
OFTEN = 10  # tests from one look at the maps to the next, which takes some 10 ms
counted = itertools.count(1)


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
