"""Makes the measurements that the fits in this folder are about: python configs/fit/make_data.py.

They are computed from known numbers, those of configs/snapback.toml (Zhu, Yin & Shen 2018, eq. 5) and
the branches below, which are no rope's, with normal noise of a stated size and seed, so that everybody
can see whether a fit finds them again.
"""

from pathlib import Path

import numpy as np

from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

HERE = Path(__file__).parent
SEED = 20180301
NOISE = 0.01  # of the largest value in a column
PRETENSIONS = (45, 180, 315, 450)  # kN
# what relaxes beside that law in the loops and the hold: EA in N and time in s
BRANCHES = ((800e3, 4.0), (400e3, 60.0))
LOOPS = (("low-10s", 0.12, 10.0), ("low-100s", 0.12, 100.0), ("high-10s", 0.20, 10.0),
         ("high-100s", 0.20, 100.0))  # fmt: skip
"""Names, mean strains and periods in s."""
AMPLITUDE, CYCLES, ROWS = 0.02, 3, 90
CHANGES = ["segments=50", "duration=100 ms", "every=1 ms", "break.time=5 ms"]


def noisy(values: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Values with the noise of a sensor."""
    return values + NOISE * np.max(np.abs(values)) * random.standard_normal(values.size)


def write(name: str, head: str, *columns: np.ndarray) -> None:
    """A CSV file with one header line."""
    note = f"# computed with noise of {100 * NOISE:g} % of the largest value, seed {SEED}"
    rows = [",".join(f"{x:.6g}" for x in row) for row in zip(*columns, strict=True)]
    (HERE / name).write_text("\n".join([note, head, *rows]) + "\n", encoding="utf-8")


def relaxing(strain: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Tensions in N of the branches: q' = EA e' - q / tau from rest, strain straight between rows."""
    total = np.zeros(time.size)
    for stiff, tau in BRANCHES:
        carried = 0.0
        for k in range(1, time.size):
            pieces = time[k] - time[k - 1], strain[k] - strain[k - 1]
            kept = np.exp(-pieces[0] / tau)
            carried = carried * kept + stiff * tau * pieces[1] / pieces[0] * (1.0 - kept)
            total[k] += carried
    return total


def cycles() -> None:
    """Quick and slow loops about two mean strains of a rope that relaxes, and a pull with a hold."""
    random = np.random.default_rng(SEED)
    law = load_study(HERE.parent / "snapback.toml").scene.materials["nylon"]
    tests = {}
    for name, mean, period in LOOPS:
        time = np.linspace(0.0, CYCLES * period, ROWS + 1)
        tests[name] = mean + AMPLITUDE * np.sin(2.0 * np.pi * time / period), time
    time = np.concatenate([np.linspace(0.0, 10.0, 21), np.geomspace(10.5, 310.0, 60)])
    tests["hold"] = np.interp(time, [0.0, 10.0], [0.05, 0.20]), time
    for name, (strain, time) in tests.items():
        load = noisy(law.curve(strain) + relaxing(strain, time), random)
        head = "time (s),strain (%),load (kN)"
        write(f"cycles-{name}.csv", head, time, 100 * strain, 1e-3 * load)


def main() -> None:
    """A bench's load-extension table, four break tests, and loops and a hold of a rope that relaxes."""
    cycles()
    random = np.random.default_rng(SEED)
    scene = HERE.parent / "snapback.toml"
    study = load_study(scene, [*CHANGES, "pretension=[45 kN, 180 kN, 315 kN, 450 kN]"])
    strain = np.linspace(0.0, 0.32, 65)
    law = study.scene.materials["nylon"]
    tension = noisy(np.maximum(law.curve(strain), 0.0), random)
    write("bench.csv", "strain (%),load (kN)", 100 * strain, 1e-3 * tension)
    target = HERE / "make_data.h5"
    run_study(study, target)
    with open_result(target) as found:
        line, time = found.line("rope"), found.time[1:]
        for k, pull in enumerate(PRETENSIONS):
            # both sensors run for 100 ms; the start itself is not recorded
            force = noisy(line.field("start_tension")[k, 1:], random)
            place = noisy(line.field("position")[k, 1:, -1, 0], random)
            write(
                f"break-{pull}kN.csv", "t (ms),wall (kN),end (m)", 1e3 * time, 1e-3 * force, place
            )
    target.unlink()


if __name__ == "__main__":
    main()
