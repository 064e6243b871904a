"""Draws the pictures of restraint.md.

python docs/restraint.py RESULTS.h5 TWO.h5 STUDY, of configs/restraint.toml and
configs/restraint-two-anchors.toml and the folder of configs/studies/restraint-envelope.toml, as far as
it is.
"""

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


def draw_two(path: str) -> None:
    """From above and over time: what configs/restraint-two-anchors.toml comes to."""
    figure, (plan, over) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    with open_result(path) as found:
        stop = found.summary()["run"]["stop_time"][0]
        seen = found.time <= stop
        for side, colour in zip(("left", "right"), COLOURS, strict=False):
            names = [f"{side}_{part}" for part in ("chain", "cable", "rod")]
            for k, style in ((0, ":"), (np.flatnonzero(seen)[-1], "-")):
                rows = [found.line(name).field("position", 0)[k] for name in names]
                x, y = np.concatenate(rows).T[:2]
                when = "at the start" if k == 0 else "at the stop"
                plan.plot(x, y, style, color=colour, linewidth=1.2, label=f"{side}, {when}")
            force = found.line(f"{side}_chain").tension(0)[seen, 0] / 1e3
            over.plot(found.time[seen], force, color=colour, linewidth=1.2, label=f"{side} anchor")
    plan.set_xlabel("x (m)")
    plan.set_ylabel("y (m)")
    over.set_xlabel("time (s)")
    over.set_ylabel("tension at the anchor (kN)")
    over.set_ylim(0.0, None)
    for axes in (plan, over):
        axes.grid(alpha=0.25)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(IMAGES / "restraint_two.svg", metadata={"Date": None})


def draw_envelope(folder: str) -> None:
    """Distance to the stop and largest tension of all runs of the study, by speed, mass and friction."""
    with open_result(folder) as found:
        whole = found.summary()["run"]
        done = np.isfinite(whole["stop_distance"])
        axes = {axis.name: np.asarray(axis.values)[done] for axis in found.axes}
        distance = whole["stop_distance"][done]
        # at any step, where the summary's is that of the outputs
        peaks = [np.max(found.line(name).field("peak_tension"), axis=1) for name in found.lines]
        force = np.max(peaks, axis=0)[done] / 1e3
    speed, mass, friction = (axes[name] for name in ("velocity_0", "ship_mass", "anchor_friction"))
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    seen = left.scatter(speed, distance, c=friction, s=4, cmap="viridis", linewidths=0)
    figure.colorbar(seen, ax=left, label="friction of the anchor (-)")
    left.set_ylabel("distance to the stop (m)")
    seen = right.scatter(speed, force, c=mass / 1e3, s=4, cmap="plasma", linewidths=0)
    figure.colorbar(seen, ax=right, label="mass of the ship (t)")
    right.set_ylabel("largest tension (kN)")
    for ax in (left, right):
        ax.set_xlabel("speed at the start (m/s)")
        ax.set_ylim(0.0, None)
        ax.grid(alpha=0.25)
    figure.savefig(IMAGES / "restraint_envelope.png", dpi=130, metadata={"Software": None})
    told = np.percentile(distance, [0, 5, 50, 95, 100])
    print(f"{done.sum()} runs; distance at least, 5 %, half, 95 %, at most: {np.round(told, 1)} m")


if __name__ == "__main__":
    draw(sys.argv[1])
    draw_joints(sys.argv[1])
    draw_two(sys.argv[2])
    draw_envelope(sys.argv[3])
