"""Makes the measurements that the fits in this folder are about: python configs/fit/make_data.py.

They are computed from known numbers, those of configs/snapback.toml (Zhu, Yin & Shen 2018, eq. 5), with
normal noise of a stated size and seed, so that everybody can see whether a fit finds them again.
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
CHANGES = ["segments=50", "duration=100 ms", "every=1 ms", "break.time=5 ms"]


def noisy(values: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Values with the noise of a sensor."""
    return values + NOISE * np.max(np.abs(values)) * random.standard_normal(values.size)


def write(name: str, head: str, *columns: np.ndarray) -> None:
    """A CSV file with one header line."""
    note = f"# computed with noise of {100 * NOISE:g} % of the largest value, seed {SEED}"
    rows = [",".join(f"{x:.6g}" for x in row) for row in zip(*columns, strict=True)]
    (HERE / name).write_text("\n".join([note, head, *rows]) + "\n", encoding="utf-8")


def main() -> None:
    """A bench's load-extension table, and four break tests."""
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
