"""Draws the pictures of restraint.md: python docs/restraint.py RESULTS.h5, of configs/restraint.toml."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from lumpedcable.results import open_result
from lumpedcable.view.style import COLOURS

IMAGES = Path(__file__).with_name("images")
SHOWN = {0: "0.3", 1: "0.5", 2: "0.7"}  # run: friction


def draw(path: str) -> None:
    """Velocities and the tension at the anchor of cases 1 to 3, over time."""
    figure, (top, bottom) = plt.subplots(
        2, 1, figsize=(7.0, 6.0), sharex=True, layout="constrained"
    )
    with open_result(path) as found:
        for colour, (run, friction) in zip(COLOURS, SHOWN.items(), strict=False):
            stop = found.summary()["run"]["stop_time"][run]
            seen = found.time <= stop
            time = found.time[seen]
            for body, style in (("ship", "-"), ("anchor", "--")):
                speed = found.body(body, "velocity", run)[seen, 0]
                label = f"{body}, friction {friction}"
                top.plot(time, speed, style, color=colour, label=label, linewidth=1.2)
            force = found.line("chain").tension(run)[seen, 0] / 1e3
            bottom.plot(time, force, color=colour, label=f"friction {friction}", linewidth=1.2)
            peak = found.line("chain").field("peak_tension", run)[0] / 1e3
            when = time[np.argmax(force)]
            bottom.plot(when, peak, "D", color=colour, markersize=4)
    top.set_ylabel("velocity (m/s)")
    bottom.set_ylabel("tension at the anchor (kN)")
    bottom.set_xlabel("time (s)")
    for axes in (top, bottom):
        axes.legend(frameon=False, ncols=1, fontsize=8)
        axes.grid(alpha=0.25)
        axes.set_xlim(0.0, None)
        axes.set_ylim(0.0, None)
    figure.savefig(IMAGES / "restraint.svg", metadata={"Date": None})


def draw_joints(path: str) -> None:
    """The largest tension of every link from the anchor to the ship, cases 1 to 5, as in figure 33."""
    figure, axes = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    labels = ("friction 0.3", "friction 0.5", "friction 0.7", "anchor of 50 t", "anchor of 60 t")
    with open_result(path) as found:
        for run, (label, colour) in enumerate(zip(labels, COLOURS, strict=False)):
            lines = ("chain", "cable", "rod")
            peaks = [found.line(name).field("peak_tension", run) for name in lines]
            whole = np.concatenate(peaks) / 1e3
            axes.plot(np.arange(1, len(whole) + 1), whole, ".-", color=colour, label=label)
        ends = np.cumsum([len(p) for p in peaks])
    for end, name in zip(ends[:2], ("chain", "cable"), strict=True):
        axes.axvline(end + 0.5, color="0.7", linewidth=0.8)
        axes.annotate(
            name, (end, 0.02), xycoords=("data", "axes fraction"), ha="right", color="0.4"
        )
    axes.set_xlabel("link, from the anchor to the ship (-)")
    axes.set_ylabel("largest tension (kN)")
    axes.set_ylim(0.0, None)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize=8, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 0.08))
    figure.savefig(IMAGES / "restraint_joints.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw(sys.argv[1])
    draw_joints(sys.argv[1])
