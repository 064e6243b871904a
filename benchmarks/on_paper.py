"""What many runs would take on a GPU, on paper: a step counted, over what makers of GPUs publish.

Nothing here is measured. Operations, bytes and kernels are those of one step as XLA compiles it for
the device at hand; its compiler for GPUs fuses by like rules, but not to the letter.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.extend import core

from benchmarks.engine import Runner, scene_of
from lumpedcable.solve.integrate import advance, begin
from lumpedcable.study.batches import GPU

DTYPE = "float32"
SEGMENTS, DURATION = 100, 0.2  # s
RUNS = (10**5, 10**7)
FEW_LANES = 1024  # too few for a GPU, beside those that a study takes
START = 2e-6  # s between the starts of two kernels that wait for each other: taken, not published
FREE = {"parameter", "constant", "copy", "tuple", "get-tuple-element", "bitcast"}  # no kernels


class Chip(NamedTuple):
    """Peaks as published: memory (bytes/s), float32 outside tensor cores (1/s)."""

    name: str
    memory: float
    float32: float


CHIPS = (Chip("H100 SXM", 3.35e12, 67e12), Chip("A100 SXM 80 GB", 2.039e12, 19.5e12))


class Count(NamedTuple):
    """Of one call: operations, those of them that are roots or transcendental, bytes, kernels."""

    operations: float
    special: float
    bytes: float
    kernels: int


def run(quick: bool) -> dict[str, Any]:
    """A step for each node more, from two meshes, and how many steps a run has."""
    few, many = (counted(*step(n)) for n in (SEGMENTS, 2 * SEGMENTS))
    each = [(b - a) / SEGMENTS for a, b in zip(few[:3], many[:3], strict=True)]
    runner = Runner(scene_of(f"segments={SEGMENTS}"))
    return {
        **dict(zip(Count._fields, each, strict=False)), "kernels": few.kernels,
        "steps": runner.steps * round(DURATION / runner.every), "nodes": SEGMENTS + 1,
    }  # fmt: skip


def step(segments: int) -> tuple[Callable[..., Any], Sequence[Any]]:
    """One step of the default method as a function, and the shapes that it takes."""
    body, shapes = traced(segments, DTYPE)
    return core.jaxpr_as_fun(body), shapes


def traced(segments: int, dtype: str) -> tuple[Any, Sequence[Any]]:
    """One step of the default method, followed, and the shapes that it takes."""
    runner = Runner(scene_of(f"segments={segments}", f'solver.dtype="{dtype}"'))
    model = jax.tree.map(lambda x: x[0], runner.ready.model)
    numbers = runner.numbers(runner.every, runner.steps)
    state, _ = begin(model, runner.plan, numbers)
    whole = jax.make_jaxpr(lambda m, s: advance(m, runner.plan, numbers, s, 0, 2))(model, state)
    # the loop inside the loop over outputs
    _, body = max(_loops(whole.jaxpr, 0), key=lambda found: found[0])
    return body, [jax.ShapeDtypeStruct(v.aval.shape, v.aval.dtype) for v in body.jaxpr.invars]


def _loops(jaxpr: Any, depth: int) -> Iterator[tuple[int, Any]]:
    for equation in jaxpr.eqns:
        if equation.primitive.name == "scan":
            yield depth, equation.params["jaxpr"]
        for value in equation.params.values():
            for one in value if isinstance(value, tuple | list) else (value,):
                if hasattr(one, "jaxpr"):
                    yield from _loops(one.jaxpr, depth + 1)
                elif hasattr(one, "eqns"):
                    yield from _loops(one, depth + 1)


def counted(function: Callable[..., Any], shapes: Sequence[Any]) -> Count:
    """What the compiled function does in a call."""
    compiled = jax.jit(function).lower(*shapes).compile()
    found, text = compiled.cost_analysis(), compiled.as_text() or ""
    kinds = re.findall(r"= \S+ ([a-z\-]+)\(", text[text.index("ENTRY") :])
    return Count(
        float(found.get("flops", 0.0)), float(found.get("transcendentals", 0.0)),
        float(found["bytes accessed"]), sum(kind not in FREE for kind in kinds),
    )  # fmt: skip


def table(data: dict[str, Any]) -> str:
    """Seconds by limit for either number of runs, on each chip."""
    rows = [
        f"| estimate, not measured: {DTYPE}, N = {SEGMENTS}, {1e3 * DURATION:g} ms | "
        + " | ".join(f"{chip.name}, {_power(runs)} runs" for chip in CHIPS for runs in RUNS) + " |",
        "|---" * (1 + len(CHIPS) * len(RUNS)) + "|",
    ]  # fmt: skip
    limits = {
        f"arithmetic: {data['operations']:.0f} operations a node-step": _arithmetic,
        f"memory: {data['bytes']:.0f} bytes a node-step": _memory,
        f"starts: {data['kernels']} kernels a step, {FEW_LANES} runs in a batch": _starts(
            FEW_LANES
        ),
        f"starts with {GPU.lanes} runs in a batch": _starts(GPU.lanes),
    }
    for words, seconds in limits.items():
        cells = (f"{_short(seconds(data, chip, n))} s" for chip in CHIPS for n in RUNS)
        rows.append(f"| {words} | {' | '.join(cells)} |")
    return "\n".join(rows)


def _node_steps(data: dict[str, Any], runs: int) -> float:
    return float(runs) * data["nodes"] * data["steps"]


def _arithmetic(data: dict[str, Any], chip: Chip, runs: int) -> float:
    return _node_steps(data, runs) * data["operations"] / chip.float32


def _memory(data: dict[str, Any], chip: Chip, runs: int) -> float:
    return _node_steps(data, runs) * data["bytes"] / chip.memory


def _starts(lanes: int) -> Callable[[dict[str, Any], Chip, int], float]:
    def seconds(data: dict[str, Any], chip: Chip, runs: int) -> float:
        return float(np.ceil(runs / lanes)) * data["steps"] * data["kernels"] * START

    return seconds


def _power(runs: int) -> str:
    return f"10^{round(np.log10(runs))}"


def _short(seconds: float) -> str:
    return f"{seconds:.0f}" if seconds >= 10.0 else f"{seconds:.2g}"
