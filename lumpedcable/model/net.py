"""The nodes of a scene as one net: which line ends share a node, and an order that keeps it narrow."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.ends import Attached, Driven, Joined
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.splices import spliced

__all__ = ["Net", "junction_forces", "make_net"]


@dataclass(frozen=True)
class Net:
    """Where each line's nodes stand in one array of all nodes, cut into blocks of `width` nodes.

    `index` gives, by line, the place (nodes,) of each of its nodes; `fixed` marks the places whose
    motion is known (those at rigid bodies, which stay where they are, among them), or which only fill up
    the last block; `tied` gives, by body, the places of the ends that are tied to it, in the order of
    `attached_ends`. Blocks couple to their neighbours alone.
    """

    index: dict[str, np.ndarray]
    fixed: np.ndarray
    width: int
    tied: dict[str, np.ndarray]

    @property
    def size(self) -> int:
        """Number of places, a multiple of `width`."""
        return self.fixed.shape[0]

    def spread(self, everything: Float[Array, "places d"]) -> Vectors:
        """Each line's nodes (d, nodes) out of all of them."""
        return {name: everything[places].T for name, places in self.index.items()}

    def gather(self, lines: Vectors) -> Float[Array, "places d"]:
        """Sum over lines of their nodal vectors, at the places of the nodes."""
        first = next(iter(lines.values()))
        total = jnp.zeros((self.size, first.shape[0]), first.dtype)
        for name, places in self.index.items():
            total = total.at[places].add(lines[name].T)
        return total

    def pick(self, lines: Vectors) -> Float[Array, "places d"]:
        """Nodal values that lines agree upon, at their places."""
        first = next(iter(lines.values()))
        total = jnp.zeros((self.size, first.shape[0]), first.dtype)
        for name, places in self.index.items():
            total = total.at[places].set(lines[name].T)
        return total


def make_net(model: Model, ordered: bool = True) -> Net:
    """The net of a model, from its structure alone.

    Where no system is to be solved on it, the order does not matter and need not be found. Of a model
    without lines it is empty.
    """
    if not model.lines:
        return Net({}, np.zeros(0, bool), 1, {})
    index, count = {}, 0
    shared: dict[int, int] = {}
    for name, line in model.lines.items():
        places = np.arange(count, count + line.segments + 1)
        count += line.segments + 1
        index[name] = places
    for name, node, end in model.outer_ends():
        if isinstance(end, Joined):
            index[name][node] = shared.setdefault(end.junction, index[name][node])
    used = np.unique(np.concatenate(list(index.values())))
    compact = np.full(count, -1)
    compact[used] = np.arange(used.size)
    index = {name: compact[places] for name, places in index.items()}

    place, width = _narrow_order(model, index, used.size) if ordered else (np.arange(used.size), 1)
    size = -(-used.size // width) * width
    fixed = np.ones(size, bool)
    fixed[: used.size] = False
    index = {name: place[places] for name, places in index.items()}
    tied: dict[str, list[int]] = {}
    for name, node, end in model.outer_ends():
        if isinstance(end, Driven | Attached):
            fixed[index[name][node]] = True
        if isinstance(end, Attached):
            tied.setdefault(end.body, []).append(int(index[name][node]))
    return Net(index, fixed, width, {name: np.array(places) for name, places in tied.items()})


def _narrow_order(model: Model, index: dict[str, np.ndarray], count: int) -> tuple[np.ndarray, int]:
    """A place for each node such that coupled nodes are at most `width` places apart."""
    # scipy.sparse takes as long to import as a small scene takes to run
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    rows, columns = [np.arange(count)], [np.arange(count)]
    for name, places in index.items():
        bending = model.lines[name].bending is not None
        for reach in (1, 2) if bending else (1,):
            if places.size > reach:
                rows += [places[:-reach], places[reach:]]
                columns += [places[reach:], places[:-reach]]
    for each in spliced(model):
        # a node next to the joint moves with both nodes of the other line there
        one, other = (
            index[name][:2] if node == 0 else index[name][-2:] for name, node in each.ends
        )
        rows += [np.repeat(one, 2), np.repeat(other, 2)]
        columns += [np.tile(other, 2), np.tile(one, 2)]
    row, column = np.concatenate(rows), np.concatenate(columns)
    graph = coo_matrix((np.ones(row.size), (row, column)), shape=(count, count)).tocsr()
    place = np.empty(count, int)
    place[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(count)
    return place, max(1, int(np.max(np.abs(place[row] - place[column]))))


def junction_forces(
    model: Model, net: Net, moved: Float[Array, "places d"]
) -> Float[Array, "places d"] | None:
    """Loads and buoyancy of junctions (N) at their places, which have `moved` (m); None without any."""
    total = None
    for junction in model.junctions:
        name, node = junction.members[0]
        place, force = int(net.index[name][node]), junction.load
        if junction.lift is not None:
            lift = junction.lift.force(model.lines[name].reference[:, node] + moved[place])
            force = lift if force is None else force + lift
        if force is not None:
            total = jnp.zeros_like(moved) if total is None else total
            total = total.at[place].add(force)
    return total
