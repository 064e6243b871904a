"""Builds `line.c` with the machine's own C compiler and runs it on the parted line."""

from __future__ import annotations

import ctypes
import functools
import itertools
import shutil
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lumpedcable.model.line import Line
from lumpedcable.physics.tension import TensionOnly
from lumpedcable.physics.tension.tanh import Tanh

__all__ = ["FLAGS", "Run", "compiler", "go", "parameters"]

SOURCE = Path(__file__).with_name("line.c")
# "exact" keeps every rounding where it is written; "fast" lets the compiler reorder, divide by
# multiplying and take tanh of four or eight numbers at once, as XLA's compiler does in all programs,
# and takes numbers below the smallest normal one for 0 while the fixture runs
FLAGS = {
    "exact": ("-O3", "-march=native"),
    "fast": ("-O3", "-march=native", "-ffast-math", "-DFLUSH"),
}
REALS = {"float64": ctypes.c_double, "float32": ctypes.c_float}
FIELDS = ("p1", "p2", "p3", "p4", "p5", "length", "mass", "drag", "strain", "hold", "time")


class Run(NamedTuple):
    """End displacements (runs,) in m, top speeds of the ends (runs,) in m/s, and the time (s)."""

    displacement: np.ndarray
    peak_speed: np.ndarray
    seconds: float


def compiler() -> str | None:
    """The C compiler, None where there is none."""
    return shutil.which("gcc") or shutil.which("cc")


@functools.cache
def library(dtype: str, flags: str) -> ctypes.CDLL:
    """The compiled fixture, built once in a folder of its own."""
    gcc = compiler()
    if gcc is None:
        raise FileNotFoundError("no C compiler: expected gcc or cc on the path")
    folder = Path(tempfile.mkdtemp(prefix="line-in-c-"))
    real = "double" if dtype == "float64" else "float"
    made, part = folder / f"line-{dtype}-{flags}.so", folder / "line.o"
    subprocess.run(
        [gcc, *FLAGS[flags], "-c", "-fPIC", f"-DREAL={real}", SOURCE, "-o", part], check=True
    )
    # linked without -ffast-math, with which it would flush such numbers in the whole process for good
    subprocess.run([gcc, "-shared", part, "-o", made, "-lm"], check=True)
    return ctypes.CDLL(str(made))


def parameters(line: Line, break_time: float) -> dict[str, float]:
    """What the fixture needs of a line of the model that it can stand in for."""
    law = line.law
    assert isinstance(law, TensionOnly)
    assert isinstance(law.law, Tanh)
    assert line.drag is not None
    own = law.law
    numbers = {
        "p1": own.p1, "p2": own.p2, "p3": own.p3, "p4": own.p4, "p5": own.p5,
        "length": line.segment_length[0], "mass": line.mass, "drag": line.drag.tangential,
    }  # fmt: skip
    return {key: float(np.ravel(value)[0]) for key, value in numbers.items()} | {"time": break_time}


def go(
    numbers: dict[str, float], strain: np.ndarray, hold: np.ndarray, segments: int, steps: int,
    dt: float, dtype: str = "float64", flags: str = "exact", threads: int = 1,
) -> Run:  # fmt: skip
    """Runs with their strains (-) and holding forces (N) through `steps` of dt (s).

    Each thread takes an equal share of the runs, one run after the other.
    """
    real, made = REALS[dtype], library(dtype, flags)

    class Layout(ctypes.Structure):
        _fields_ = [(name, real) for name in FIELDS]

    line = Layout(**numbers)
    runs = len(strain)
    strain, hold = (np.ascontiguousarray(x, dtype) for x in (strain, hold))
    u, v = (np.zeros((runs, segments + 1), dtype) for _ in range(2))
    peak = np.zeros(runs, dtype)

    def part(first: int, last: int) -> None:
        at = [x[first:last].ctypes.data_as(ctypes.c_void_p) for x in (strain, hold, u, v, peak)]
        made.run(
            ctypes.byref(line), ctypes.c_int(last - first), at[0], at[1], ctypes.c_int(segments),
            ctypes.c_long(steps), real(dt), at[2], at[3], at[4],
        )  # fmt: skip

    cuts = np.linspace(0, runs, threads + 1).astype(int)
    workers = [threading.Thread(target=part, args=pair) for pair in itertools.pairwise(cuts)]
    begin = time.perf_counter()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return Run(u[:, -1], peak, time.perf_counter() - begin)
