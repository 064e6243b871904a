"""How many runs, steps and outputs go together: programs to compile against lanes that idle."""

from collections.abc import Sequence

import jax
import numpy as np

from lumpedcable.model.layout import Layout
from lumpedcable.scene import Scene

__all__ = [
    "CALL",
    "COMPILING",
    "GPU_LANES",
    "LANES",
    "batch_sizes",
    "lane_time",
    "lanes",
    "outputs_at_once",
    "sizes_for",
    "steps_at_once",
]

LANES = 64  # runs that are advanced together on each core, whose cache their states stay in,
GPU_LANES = 1024  # and on each GPU, where fewer would wait for kernels to start: a shard's
MANY = 1024  # runs beyond which filling up batches costs less than compiling for their sizes
COMPILING = 10.0  # s: what a batch of another size costs before it starts, most of it compiling
CALL = 8  # lanes that take as long as what a batch takes besides them
NODE_STEP = 1e-7  # s, roughly: what a step of a node takes with all that belongs to it
ROOM = 2**23  # bytes of outputs in one call: more of them wait for fresh memory from the system
CALL_TIME = 5.0  # s, by NODE_STEP: what a call takes at most, far less than that most often
OUTPUTS = (3, 8)  # powers of two: least and most outputs in one call


def batch_sizes(runs: int) -> tuple[int, ...]:
    """Sizes of the batches of a study of `runs` runs, rising.

    A size is a compiled program, which takes seconds; a lane that repeats another run takes the time
    of a run. So a few runs are hardly filled up, as many as fit into one batch go together, and many
    have two sizes.
    """
    each = LANES if jax.default_backend() == "cpu" else GPU_LANES
    full = each * jax.device_count()
    small = full // 4
    if runs <= small:
        return tuple(2**k for k in range((small - 1).bit_length() + 1))
    if runs <= full:
        return 1, 4, *range(small, full + 1, max(small // 4, 1))
    return (1, 4, small, full) if runs <= MANY else (small, full)


def lanes(runs: int, sizes: tuple[int, ...]) -> list[int]:
    """The batches that `runs` runs go through time in; the last may have lanes to fill up."""
    found = []
    while runs > 0:
        enough = [size for size in sizes if runs <= size <= 2 * runs]
        below = [size for size in sizes if size <= runs]
        size = enough[0] if enough else max(below, default=sizes[0])
        found.append(size)
        runs -= size
    return found


def sizes_for(
    groups: Sequence[tuple[int, float]], sizes: tuple[int, ...], each: float
) -> tuple[int, ...]:
    """Which of `sizes` to go by, so that programs and lanes together take the least time.

    Of the sizes that `lanes` would use it gives up those whose programs take longer to compile than
    lanes that repeat a run in batches of another size take to go through time.

    Args:
        groups: runs that are stepped alike: how many, and what a lane of them takes (s).
        sizes: all there are, rising.
        each: how many runs of the whole study need the same programs.
    """
    used = {size for runs, _ in groups for size in lanes(runs, sizes)}
    kept = {sizes[-1]} if each >= sizes[-1] else set()  # other runs need that program anyway
    again = max(each / MANY, 1.0)

    def cost(some: set[int]) -> float:
        through = (
            time * sum(size + CALL for size in lanes(runs, tuple(sorted(some))))
            for runs, time in groups
        )
        return COMPILING * len(some) + again * sum(through)

    used |= kept
    while len(used) > 1:
        fewer = min((used - {size} for size in used - kept), key=cost, default=used)
        if cost(fewer) >= cost(used):
            break
        used = fewer
    return tuple(sorted(used))


def lane_time(scene: Scene, layout: Layout, steps: int) -> float:
    """What a run of so many steps in an output interval takes in a batch (s), roughly."""
    return NODE_STEP * _nodes(layout) * steps * max(scene.output.count, 1)


def steps_at_once(layout: Layout, runs: int) -> int:
    """The most steps that `runs` runs take in one call, which nothing interrupts."""
    return max(1, int(CALL_TIME / (NODE_STEP * _nodes(layout) * runs)))


def outputs_at_once(layout: Layout, runs: int, fields: tuple[str, ...], after: int) -> int:
    """Outputs that one call of `runs` runs may return: a power of two, as many as fit into `ROOM`.

    Few calls, since each costs as much as a hundred steps of a short line. `fields` are kept of every
    `after`th output.
    """
    per_node = {"position": 3, "velocity": 3, "tension": 1, "strain": 1}
    numbers = sum(per_node.get(quantity, 0) for quantity in fields) / after + 1
    most = ROOM / (8.0 * runs * _nodes(layout) * numbers)
    return int(2 ** np.clip(np.floor(np.log2(most)), *OUTPUTS))


def _nodes(layout: Layout) -> int:
    """Nodes of all lines; all that has none counts as one more."""
    return 1 + sum(piece.segments + 1 for piece in layout.pieces)
