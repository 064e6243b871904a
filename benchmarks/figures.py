"""The pictures of the report, in the style of the package's own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from benchmarks.cases import MAIN
from benchmarks.methods import DEFAULT, USABLE
from benchmarks.peers.compare import LINEAR
from lumpedcable.view.style import NEUTRAL, curve, foot, label_outer, panel_figure, save

Points = Sequence[dict[str, Any]]

MARKERS = "osD^v<>P"
QUANTITIES = {
    "velocity": "end velocity", "displacement": "end displacement",
    "tension": "wall tension at 1 ms", "tension_fine": "wall tension at 0.1 ms",
}  # fmt: skip
DRAWN = ("displacement", "velocity", "tension_fine")
PEERS = ("lumpedcable", "MoorDyn", "SciPy")


def work_precision(points: Points, kind: str, quantity: str) -> Figure:
    """Error against time, one panel per pretension, one curve per method, a mark per mesh."""
    cases = [
        c.name for c in MAIN if c.name.endswith(kind) and any(p["case"] == c.name for p in points)
    ]
    meshes = sorted({p["segments"] for p in points})
    figure, axes = panel_figure(
        [case.split(",")[0] for case in cases],
        f"Error of the {QUANTITIES[quantity]} against computing time, break {kind}",
        height=2.4,
    )
    names = list(dict.fromkeys(p["method"] for p in points if p["case"] in cases))
    for ax, case in zip(axes, cases, strict=True):
        for i, name in enumerate(names):
            own = sorted(
                (p for p in points if (p["method"], p["case"]) == (name, case)),
                key=lambda p: p["segments"],
            )
            _curve(ax, own, quantity, i, strong=name == DEFAULT)
        _logarithmic(ax)
    label_outer(axes, "time (ms)", "error (%)")
    told = ", ".join(map(str, meshes))
    foot(
        figure,
        f"Marks from left to right: N = {told}, as far as a method's time and stability go.",
        _handles(names),
    )
    return figure


def peers(points: Points, quantity: str, kind: str) -> Figure:
    """The same for other programs: of a peer the best setting on each mesh."""
    cases = [
        c.name for c in MAIN if c.name.endswith(kind) and any(p["case"] == c.name for p in points)
    ]
    who = [
        (program, setting)
        for program, setting in dict.fromkeys(
            (p["program"], p["setting"] if p["program"] == "lumpedcable" else "")
            for p in points if p["case"] in cases
        )
        if program in PEERS
    ]  # fmt: skip
    figure, axes = panel_figure(
        [case.split(",")[0] for case in cases],
        f"Other programs on the same line: error of the {QUANTITIES[quantity]}, break {kind}",
        height=2.4,
    )
    for ax, case in zip(axes, cases, strict=True):
        for i, (program, setting) in enumerate(who):
            own = [
                p for p in points
                if (p["program"], p["case"]) == (program, case) and setting in ("", p["setting"])
                and np.isfinite(p["errors"][quantity])
            ]  # fmt: skip
            best = [
                min((p for p in own if p["segments"] == n), key=lambda p: p["errors"][quantity])
                for n in sorted({p["segments"] for p in own})
            ]
            _curve(ax, best, quantity, i, strong=setting == DEFAULT)
        _logarithmic(ax)
    label_outer(axes, "time (ms)", "error (%)")
    meshes = ", ".join(map(str, sorted({p["segments"] for p in points if p["case"] != LINEAR})))
    foot(
        figure,
        f"Marks from left to right: N = {meshes}. "
        "Of MoorDyn and SciPy the best of several settings on each mesh.",
        _handles([f"lumpedcable, {setting}" if setting else program for program, setting in who]),
    )
    return figure


def cost(data: dict[str, Any]) -> Figure:
    """Time of a step against segments, and throughput against batch size."""
    figure, (left, right) = panel_figure(["one step", "a batch, N = 100"], "", height=2.4)
    for i, waves in enumerate(dict.fromkeys(row["waves"] for row in data["step"])):
        own = [row for row in data["step"] if row["waves"] == waves]
        left.plot(
            [r["segments"] for r in own], [1e6 * r["step"] for r in own], label=waves,
            marker=MARKERS[i], markersize=3, **curve(i),
        )  # fmt: skip
    left.set(xscale="log", yscale="log", xlabel="segments", ylabel="time (µs)")
    left.legend()
    batch = data["batch"]
    right.plot(
        [b["lanes"] for b in batch], [b["rate"] / 1e6 for b in batch], marker="o", markersize=3,
        **curve(0),
    )  # fmt: skip
    right.set(
        xscale="log", yscale="log", xlabel="lines in the batch", ylabel="million node-steps per s"
    )
    for ax in (left, right):
        _plain(ax)
        ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    return figure


def _curve(ax: Axes, own: Points, quantity: str, i: int, strong: bool) -> None:
    good = [p for p in own if p["status"] in USABLE and np.isfinite(p["errors"][quantity])]
    ax.plot(
        [1e3 * p["warm"] for p in good], [100 * p["errors"][quantity] for p in good],
        marker=MARKERS[i % len(MARKERS)], markersize=3.5 if strong else 2.5, **_line(i, strong),
    )  # fmt: skip


def _line(i: int, strong: bool) -> dict[str, Any]:
    return curve(i) | {"linewidth": 1.8 if strong else 0.9, "zorder": 3 if strong else 2}


def _handles(names: Sequence[str]) -> list[Line2D]:
    return [
        Line2D(
            [],
            [],
            label=name,
            marker=MARKERS[i % len(MARKERS)],
            markersize=3,
            **_line(i, name.endswith(DEFAULT)),
        )
        for i, name in enumerate(names)
    ]


def _logarithmic(ax: Axes) -> None:
    ax.set(xscale="log", yscale="log")
    for level in (1.0, 0.1):
        ax.axhline(level, color=NEUTRAL, linewidth=0.6, zorder=1)
    _plain(ax)


def _plain(ax: Axes) -> None:
    """Numbers as people write them on logarithmic axes."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw(parts: dict[str, Any], folder: Path, form: str = "svg") -> list[Path]:
    """All pictures that the parts allow."""
    made: list[Path] = []
    if "work-precision" in parts:
        points = parts["work-precision"]["points"]
        for kind in ("5 ms", "at once"):
            for quantity in DRAWN:
                if any(p["case"].endswith(kind) for p in points):
                    name = f"{quantity.replace('_', '-')}-{kind.replace(' ', '-')}"
                    made += save(
                        lambda k=kind, q=quantity: work_precision(points, k, q),
                        folder / name,
                        (form,),
                    )
    if "peers" in parts:
        others = parts["peers"]["points"]
        made += save(
            lambda: peers(others, "velocity", "at once"), folder / "peers-at-once", (form,)
        )
    if "cost" in parts:
        made += save(lambda: cost(parts["cost"]), folder / "cost", (form,))
    return made
