"""Loops and holds of the nylon rope with branches that relax, from the exact sum of its history."""

import numpy as np
from engine_runs import nylon_rope
from fit_files import fit_of
from nylon_line import tension

SCENE = nylon_rope(20, "20 ms")
BRANCHES = np.array([[150e3, 4.0], [90e3, 60.0]])
"""EA (N) and time (s) of the branches "fast" and "slow"."""
NAMES = [f"materials.nylon.relaxation.{b}.{k}" for b in ("fast", "slow") for k in ("EA", "time")]
LOOPS = (("quick", 0.1, 10.0), ("lazy", 0.1, 100.0), ("high", 0.2, 20.0))
"""Names, mean strains (-) and periods (s)."""
HOLD = (np.concatenate([np.linspace(0.0, 10.0, 11), np.geomspace(11.0, 310.0, 40)]), 0.05, 0.2)


def history(strain, time, branches=BRANCHES):
    """sum over rows j of EA int exp(-(t - s) / tau) de (N), each straight piece by its own integral."""
    total = np.zeros(len(time))
    for k in range(len(time) - 1):
        h, rise = time[k + 1] - time[k], strain[k + 1] - strain[k]
        for stiff, tau in branches:
            share = 1.0 if h == 0.0 else -np.expm1(-h / tau) * tau / h
            total[k + 1 :] += stiff * rise * share * np.exp(-(time[k + 1 :] - time[k + 1]) / tau)
    return total


def loop(mean, period, points=60, cycles=2):
    """Strains and times of a loop."""
    time = np.linspace(0.0, cycles * period, points)
    return mean + 0.02 * np.sin(2.0 * np.pi * time / period), time


def hold():
    """Strains and times of a pull in 10 s and a hold of five minutes."""
    time, low, high = HOLD
    return np.interp(time, [0.0, 10.0], [low, high]), time


def write(folder, name, strain, time, load):
    """Time in s, strain in per cent, load in kN, all digits."""
    rows = zip(time.tolist(), strain.tolist(), load.tolist(), strict=True)
    lines = [f"{t!r},{100 * e!r},{f / 1e3!r}" for t, e, f in rows]
    (folder / name).write_text("time (s),strain (%),load (kN)\n" + "\n".join(lines) + "\n")


def measure(folder, noise=0.0, seed=0, branches=BRANCHES):
    """Three loops and a hold, with noise of a share of the largest load of each."""
    random = np.random.default_rng(seed)
    tests = {name: loop(mean, period) for name, mean, period in LOOPS} | {"hold": hold()}
    for name, (strain, time) in tests.items():
        load = tension(strain) + history(strain, time, branches)
        load = load + noise * load.max() * random.standard_normal(load.size)
        write(folder, f"{name}.csv", strain, time, load)
    return list(tests)


def experiment(name, noise="", file=""):
    """A bench's table with times."""
    return f"""
[experiments.{name}]
material = "nylon"
file = "{file or name}.csv"
strain = {{ column = "strain" }}
tension = {{ column = "load" }}
time = {{ column = "time" }}
{f'noise = "{noise}"' if noise else ""}
"""


def start_text(starts, names=NAMES):
    """A scene whose nylon relaxes, and free numbers of its branches with start values."""
    rows = "".join(
        f'"{n}" = {{ start = {float(x)!r} }}\n' for n, x in zip(names, starts, strict=True)
    )
    return f"""scene = "scene.toml"
[set]
"materials.nylon.relaxation" = {{ fast = {{ EA = 1e5, time = 2 }}, slow = {{ EA = 1e5, time = 50 }} }}
[free]
{rows}"""


def cycles_of(folder, starts, noise=0.0, seed=0, more="", known="", branches=BRANCHES):
    """A fit of three loops and a hold for the branches, the law being known."""
    names = measure(folder, noise, seed, branches)
    text = start_text(starts) + "".join(experiment(name, known) for name in names) + more
    return fit_of(folder, text, SCENE)
