"""A file of eight runs to be exported, and one of which a run goes wrong."""

import h5py
import pytest
import synthetic_result
from exported import HALF, RUN

from lumpedcable.results import open_result


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "r.h5"
    return synthetic_result.snapback(path, segments=8, sag=4.0, padded=1)


@pytest.fixture(scope="module")
def fields(file):
    """Places, velocities and tensions of the run, without the padding."""
    with open_result(file) as result:
        rope = result.line("rope")
        return rope.position(RUN)[:, :9], rope.velocity(RUN)[:, :9], rope.tension(RUN)[:, :8]


@pytest.fixture(scope="module")
def blown(tmp_path_factory):
    """The same file, of whose run 3 all from half-way on, when it went wrong, is beyond all bounds."""
    path = tmp_path_factory.mktemp("export") / "blown.h5"
    synthetic_result.snapback(path, segments=8, sag=4.0, padded=1, failed=(RUN,))
    with h5py.File(path, "r+") as changed:
        for name in ("position", "velocity", "tension", "strain"):
            changed[f"lines/rope/{name}"][RUN, HALF:] = 1e35
        changed["energy/kinetic"][RUN, HALF:] = 1e125
    return path
