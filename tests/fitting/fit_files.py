"""Fits for the tests: scenes, fit files and data that are made on the spot from known numbers."""

import numpy as np
from engine_runs import nylon_rope
from nylon_line import P1, P2, P3, P4, P5, tension

from lumpedcable.fitting.load import load_fit

TRUTH = np.array([P1, P2, P3, P4, P5])
NAMES = [f"materials.nylon.p{k}" for k in range(1, 6)]

# a line that is not simulated, so that the scene is complete
SCENE = nylon_rope(20, "20 ms")
BENCH = """
[experiments.bench]
material = "nylon"
file = "bench.csv"
strain = { column = "strain (%)" }
tension = { column = "load", unit = "kN" }
"""


def free(values, names=NAMES, **more):
    """The [free] table with start values."""
    extra = "".join(f", {key} = {value}" for key, value in more.items())
    rows = [
        f'"{n}" = {{ start = {float(v)!r}{extra} }}' for n, v in zip(names, values, strict=True)
    ]
    return "[free]\n" + "\n".join(rows) + "\n"


def write_bench(folder, strain, load, name="bench.csv"):
    """A bench's table: strain in per cent, load in kN, all digits."""
    rows = [f"{100 * e!r},{t / 1e3!r}" for e, t in zip(strain.tolist(), load.tolist(), strict=True)]
    (folder / name).write_text("strain (%),load\n" + "\n".join(rows) + "\n")


def bench_of(folder, starts, noise=0.0, seed=0, points=64, more="", scene=SCENE, extra=""):
    """A fit of a bench's table of the nylon law, with noise of a share of the largest tension."""
    strain = np.linspace(0.005, 0.32, points)
    load = tension(strain)
    load = load + noise * load.max() * np.random.default_rng(seed).standard_normal(points)
    write_bench(folder, strain, load)
    return fit_of(folder, 'scene = "scene.toml"\n' + extra + free(starts) + BENCH + more, scene)


def fit_of(folder, text, scene=SCENE):
    """The fit of a file's text."""
    (folder / "scene.toml").write_text(scene)
    path = folder / "fit.toml"
    path.write_text(text)
    return load_fit(path)
