"""How many runs, steps and outputs go together: programs to compile against lanes that idle."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from lumpedcable.model.layout import Layout
from lumpedcable.scene import Scene

__all__ = [
    "COMPILING",
    "CPU",
    "GPU",
    "Kind",
    "batch_sizes",
    "kind",
    "lane_time",
    "lanes",
    "nodes_of",
    "outputs_at_once",
    "shard_size",
    "sizes_for",
    "step_time",
    "steps_at_once",
]


class Kind(NamedTuple):
    """What suits a kind of device.

    `lanes` are the most runs that are advanced together on each device; fewer of long lines, so that
    they have `nodes` at most together. `block` are the runs whose start states are held at once, and
    at most those of a shard unless it is asked otherwise: seconds of work, so that little is lost and
    little is written too often. `call` lanes take as long as what a batch takes
    besides them, a step of a node `node_step` (s), roughly, with all that belongs to it. Outputs of one
    call have `room` (bytes), and the first is asked for `first` of them.
    """

    lanes: int
    nodes: int
    block: int
    call: int
    node_step: float
    room: int
    first: int


# each core has a cache that the states stay in; more outputs wait for fresh memory from the system
CPU = Kind(lanes=64, nodes=2**62, block=1024, call=8, node_step=1e-7, room=2**23, first=16)
# fewer lanes wait for kernels to start, which takes as long as some thousand of them; more lanes are
# 1.7 times as fast, of which a study sees nothing, since it waits for its files and sums then
GPU = Kind(lanes=8192, nodes=2**20, block=8192, call=4096, node_step=1e-10, room=2**30, first=128)
FEWEST = 64  # lanes on each device, however long the lines
SHARDS = 8  # of a study, unless they would be smaller than a batch
MANY = 1024  # runs beyond which filling up batches costs less than compiling for their sizes
COMPILING = 10.0  # s: what a batch of another size costs before it starts, most of it compiling
CALL_TIME = 5.0  # s, by `Kind.node_step`: what a call takes at most, far less than that most often
OUTPUTS = (3, 8)  # powers of two: least and most outputs in one call


def kind() -> Kind:
    """What suits the devices that jax has."""
    return CPU if jax.default_backend() == "cpu" else GPU


def shard_size(runs: int) -> int:
    """Runs in each shard of a study that asks for no other number.

    Full batches, enough of them that a small study too has some shards: an interruption loses those
    that are under way, and workers share out whole ones.
    """
    full = kind().lanes * jax.device_count()
    return min(kind().block, full * -(-runs // (SHARDS * full)))


def batch_sizes(runs: int, nodes: int = 1) -> tuple[int, ...]:
    """Sizes of the batches of a study of `runs` runs with so many nodes each, rising.

    A size is a compiled program, which takes seconds; a lane that repeats another run takes the time
    of a run. So a few runs are hardly filled up, as many as fit into one batch go together, and many
    have two sizes.
    """
    most = max(kind().nodes // nodes, FEWEST)
    each = min(2 ** (most.bit_length() - 1), kind().lanes)
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
    again, call = max(each / MANY, 1.0), kind().call

    def cost(some: set[int]) -> float:
        through = (
            time * sum(size + call for size in lanes(runs, tuple(sorted(some))))
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


def step_time(layout: Layout) -> float:
    """What a step of a run takes in a batch (s), roughly."""
    return kind().node_step * nodes_of(layout)


def lane_time(scene: Scene, layout: Layout, steps: int) -> float:
    """What a run of so many steps in an output interval takes in a batch (s), roughly."""
    return step_time(layout) * steps * max(scene.output.count, 1)


def steps_at_once(layout: Layout, runs: int) -> int:
    """The most steps that `runs` runs take in one call, which nothing interrupts."""
    return max(1, int(CALL_TIME / (step_time(layout) * runs)))


def outputs_at_once(layout: Layout, runs: int, fields: tuple[str, ...], after: int) -> int:
    """Outputs that one call of `runs` runs may return: a power of two, as many as there is room for.

    Few calls, since each costs as much as a hundred steps of a short line. `fields` are kept of every
    `after`th output.
    """
    per_node = {"position": 3, "velocity": 3, "tension": 1, "strain": 1, "bending_moment": 1}
    numbers = sum(per_node.get(quantity, 0) for quantity in fields) / after + 1
    most = kind().room / (8.0 * runs * nodes_of(layout) * numbers)
    return int(2 ** np.clip(np.floor(np.log2(most)), *OUTPUTS))


def nodes_of(layout: Layout) -> int:
    """Nodes of all lines; all that has none counts as one more."""
    return 1 + sum(piece.segments + 1 for piece in layout.pieces)
