"""Runs a batch of parted lines and prints its largest resident memory: a process for cost.memory."""

from __future__ import annotations

import json
import resource
import sys
from pathlib import Path

import jax
import jax.numpy as jnp

from benchmarks.engine import Runner, scene_of
from lumpedcable.study.compiled import advance_batch, begin_batch
from lumpedcable.study.plan import plan_of, structure_of


def peak() -> int:
    """Largest resident memory of this process so far (bytes).

    Where Linux tells it directly; getrusage counts what the parent had when it made this process.
    """
    status = Path("/proc/self/status")
    if status.exists():
        line = next(x for x in status.read_text().splitlines() if x.startswith("VmHWM"))
        return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main(segments: int, lanes: int) -> None:
    """Go through one piece of a run, which is all that memory ever holds, and print what it took."""
    jnp.zeros(1).block_until_ready()
    before = peak()
    runner = Runner(scene_of(f"segments={segments}"))
    models = jax.tree.map(lambda x: jnp.repeat(x, lanes, axis=0), runner.ready.packed)
    numbers = runner.numbers(runner.every, runner.steps)
    plan = plan_of(runner.scene, structure_of(runner.scene).layout, lanes)
    state, _ = begin_batch(models, plan, numbers)
    done = advance_batch(models, plan, numbers, state, jnp.asarray(0), jnp.asarray(8))
    jax.block_until_ready(done)
    print(json.dumps({"peak": peak(), "before": before}))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
