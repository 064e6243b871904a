"""Lines that are alike go through a traced program together: what is done to each is done once to all.

A scene's lines are followed one after the other, so that a program of four of them is four times as long
as that of one, and takes more than four times as long to compile. Here the operations that differ only
in which line they belong to are found in the traced program, and made one operation on arrays that have
these lines as a first axis; what joins lines, or is done to one alone, stays as it is. Loops carry the
arrays of lines that are alike as one.

Two operations are taken for one of two lines where they are the same in kind, and each operand is either
the same value, or what one earlier operation made of each of the two lines. By induction neither can
wait for the other, so that they can be done when the first of them is due.
"""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.extend import core
from jax.tree_util import DictKey

from lumpedcable.study.differing import ALONG, ELEMENTWISE, INLINE, MOVING, alone, inner

__all__ = ["together"]

Rows = tuple[int, ...]  # lines, by number
Label = tuple[Hashable, int]  # what a value is of a line, and of which line
PLAIN = ELEMENTWISE | ALONG | MOVING  # operations without functions in them


def together(function: Callable[..., Any], groups: Iterable[Sequence[str]], *arguments: Any) -> Any:
    """`function(*arguments)`, with what is done to each line of a group done to all of it at once.

    Which of the arguments' arrays are of which line is told by the keys of the dictionaries that they
    are in: its name, or "NAME.start" and the like. The results are those of the function itself, to
    rounding; derivatives are to be taken inside of it.

    Args:
        function: of trees of arrays.
        groups: names of lines that are alike, as `model.line.alike` finds them.
        arguments: what the function is given.
    """
    flat, _ = jax.tree.flatten_with_path(arguments)
    labels = _labels(flat, groups)
    if not labels:
        return function(*arguments)
    closed, shapes = jax.make_jaxpr(function, return_shape=True)(*arguments)
    program = _Program(closed)
    values = _Values({ref: x for ref, (_, x) in zip(program.inputs, flat, strict=True)}, {})
    found = program.run(values, {program.inputs[k]: label for k, label in labels.items()})
    return jax.tree.unflatten(jax.tree.structure(shapes), [values.one(ref) for ref in found])


def _labels(flat: list[Any], groups: Iterable[Sequence[str]]) -> dict[int, Label]:
    """By number of an array, what it is and of which line, for lines with others like them."""
    number, group_of = {}, {}
    for g, names in enumerate(names for names in groups if len(names) > 1):
        for name in names:
            number[name], group_of[name] = len(number), g
    found = {}
    for k, (path, x) in enumerate(flat):
        for depth, step in enumerate(path):
            if not isinstance(step, DictKey) or not isinstance(step.key, str):
                continue
            name, dot, rest = step.key.partition(".")
            if name in number:
                others = (path[:depth], group_of[name], dot + rest, path[depth + 1 :])
                found[k] = (("given", *others, jnp.shape(x), jnp.result_type(x)), number[name])
                break
    return found


class _Values:
    """Values by number, each by itself or as a row of the values of several lines.

    `labels` tell of which line a value is, and `members` where those of the other lines are.
    """

    def __init__(self, single: dict[int, Any], stacks: dict[Any, tuple[Rows, Any]]) -> None:
        self.single, self.stacks = single, stacks
        self.labels: dict[int, Label] = {}
        self.members: dict[Hashable, dict[int, int]] = {}

    def one(self, ref: int) -> Any:
        """A value by itself."""
        if ref not in self.single:
            pack, row = self.labels[ref]
            rows, stack = self.stacks[pack]
            self.single[ref] = lax.index_in_dim(stack, rows.index(row), keepdims=False)
        return self.single[ref]

    def all(self, pack: Hashable, wanted: Rows) -> Any:
        """The values of some lines, as one array with an axis of lines before its own."""
        if pack not in self.stacks:
            rows = tuple(sorted(self.members[pack]))
            self.stacks[pack] = rows, self._stacked([self.members[pack][row] for row in rows])
        rows, stack = self.stacks[pack]
        if rows == wanted:
            return stack
        return self._stacked([self.members[pack][row] for row in wanted])

    def side_by_side(self, refs: list[int], rows: Rows) -> Any:
        """Values of some lines as one array: as it is, where they were found together."""
        found = [self.labels.get(ref) for ref in refs]
        pack = found[0][0] if found[0] is not None else None
        if pack is not None and found == [(pack, row) for row in rows]:
            return self.all(pack, rows)
        return self._stacked(refs)

    def _stacked(self, refs: list[int]) -> Any:
        return jnp.stack([jnp.asarray(self.one(ref)) for ref in refs])


@dataclass(frozen=True, eq=False)
class _Op:
    """An operation: what it is, in which function, and the numbers of what it takes and makes."""

    eqn: Any
    jaxpr: Any
    operands: tuple[int, ...]
    results: tuple[int, ...]

    @property
    def name(self) -> str:
        return self.eqn.primitive.name

    @property
    def kind(self) -> Hashable:
        """What is the same of two operations that do the same."""
        params = tuple(sorted(self.eqn.params.items(), key=lambda item: item[0]))
        try:
            hash(params)
        except TypeError:
            return id(self)
        return self.name, params, tuple((a.aval.shape, a.aval.dtype) for a in self.eqn.invars)

    def done(self, *operands: Any) -> list[Any]:
        """Its results."""
        if self.name in PLAIN:
            found = self.eqn.primitive.bind(*operands, **self.eqn.params)
            return list(found) if self.eqn.primitive.multiple_results else [found]
        run, variables = alone(self.eqn, self.jaxpr)
        given = zip(self.eqn.invars, operands, strict=True)
        by = {v: x for v, x in given if not isinstance(v, core.Literal)}
        return run(*(by[v] for v in variables))

    def done_to_all(self, operands: list[Any], own: list[bool], count: int) -> list[Any]:
        """Its results for `count` lines; `own` tells which operands have an axis of lines."""
        if self.name not in ("dynamic_slice", "dynamic_update_slice"):
            axes = [0 if each else None for each in own]
            return jax.vmap(self.done, in_axes=axes)(*operands)
        # jax would make a gathering or scattering of it, which takes far longer
        arrays = 1 if self.name == "dynamic_slice" else 2
        whole, *part = [
            x if each else jnp.broadcast_to(x, (count, *jnp.shape(x)))
            for x, each in zip(operands[:arrays], own, strict=False)
        ]
        start = operands[arrays:]
        start = [jnp.zeros((), jnp.result_type(start[0])), *start]
        if part:
            return [lax.dynamic_update_slice(whole, part[0], start)]
        return [lax.dynamic_slice(whole, start, (count, *self.eqn.params["slice_sizes"]))]


class _Program:
    """A traced function as a list of operations on numbered values."""

    def __init__(self, closed: Any) -> None:
        self.ops: list[_Op] = []
        self.constants: dict[int, Any] = {}
        self._literals: dict[Hashable, int] = {}
        self._numbers = count()
        self.inputs = [next(self._numbers) for _ in closed.jaxpr.invars]
        self.outputs = self._followed(closed, self.inputs)

    def _followed(self, closed: Any, given: Sequence[int]) -> list[int]:
        """Take in a function, with those within it in their places; the numbers of its results."""
        jaxpr = closed.jaxpr
        known = dict(zip(jaxpr.invars, given, strict=True))
        for var, value in zip(jaxpr.constvars, closed.consts, strict=True):
            known[var] = self._constant(("constant", id(value)), value)

        def read(atom: Any) -> int:
            if not isinstance(atom, core.Literal):
                return known[atom]
            kind: Any = atom.aval
            value = np.asarray(atom.val, kind.dtype)
            return self._constant((value.dtype, value.shape, value.tobytes()), value)

        for eqn in jaxpr.eqns:
            operands = [read(atom) for atom in eqn.invars]
            if eqn.primitive.name in INLINE:
                results = self._followed(inner(eqn), operands)
            else:
                results = [next(self._numbers) for _ in eqn.outvars]
                self.ops.append(_Op(eqn, jaxpr, tuple(operands), tuple(results)))
            known.update(zip(eqn.outvars, results, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def _constant(self, key: Hashable, value: Any) -> int:
        if key not in self._literals:
            self._literals[key] = next(self._numbers)
            self.constants[self._literals[key]] = value
        return self._literals[key]

    def run(self, values: _Values, labels: dict[int, Label]) -> list[int]:
        """Work out all values from those of the inputs; the numbers of the results.

        `labels` tell of which lines the inputs are.
        """
        plan = _Plan(self, labels)
        values.single |= self.constants
        values.labels, values.members = plan.labels, plan.members
        for op in self.ops:
            plan.carry_out(op, values)
        return [plan.same(ref) for ref in self.outputs]


class _Plan:
    """Which operations of a program are done together, and which are done already."""

    def __init__(self, program: _Program, labels: dict[int, Label]) -> None:
        self.labels: dict[int, Label] = {}
        self.members: dict[Hashable, dict[int, int]] = defaultdict(dict)
        for ref, (pack, row) in labels.items():
            self._label(ref, pack, row)
        self._keys: dict[Hashable, int] = {}
        self._known: dict[Hashable, tuple[int, ...]] = {}
        self._aliases: dict[int, int] = {}  # values that are worked out twice, by the first
        self._groups: dict[int, dict[int, _Op]] = defaultdict(dict)
        self._group_of: dict[_Op, int] = {}
        self._done: set[int] = set()
        self._twice: set[_Op] = set()
        for op in program.ops:
            self._place(op)

    def same(self, ref: int) -> int:
        """The number that stands for a value."""
        return self._aliases.get(ref, ref)

    def _place(self, op: _Op) -> None:
        """Find an operation's group."""
        operands = [self.same(ref) for ref in op.operands]
        if op.name == "while":
            self._place_loop(op, operands)
            return
        lines = {self.labels[ref][1] for ref in operands if ref in self.labels}
        single = lines.pop() if len(lines) == 1 else None
        own = [ref in self.labels and single is not None for ref in operands]
        what = tuple(
            ("line", self.labels[ref][0]) if mine else ref
            for ref, mine in zip(operands, own, strict=True)
        )
        # numbered: a key that holds those before it would grow as the program does
        key = self._keys.setdefault((op.kind, what), len(self._keys))
        if (key, single) in self._known:
            self._aliases.update(zip(op.results, self._known[key, single], strict=True))
            self._twice.add(op)
            return
        self._known[key, single] = op.results
        if single is None or not _groupable(op, own):
            return
        self._groups[key][single] = op
        self._group_of[op] = key
        for j, ref in enumerate(op.results):
            self._label(ref, (key, j), single)

    def _place_loop(self, op: _Op, operands: list[int]) -> None:
        """The results of a loop are of the lines that what it starts from is of."""
        carried = operands[op.eqn.params["cond_nconsts"] + op.eqn.params["body_nconsts"] :]
        for pack, rows in _packs(carried, self.labels).items():
            for row, position in rows.items():
                self._label(op.results[position], (op.results, pack), row)

    def _label(self, ref: int, pack: Hashable, row: int) -> None:
        self.labels[ref] = (pack, row)
        self.members[pack][row] = ref

    def carry_out(self, op: _Op, values: _Values) -> None:
        """Do an operation, and what goes with it."""
        if op in self._twice:
            return
        operands = [self.same(ref) for ref in op.operands]
        key = self._group_of.get(op)
        if op.name == "while":
            _loop(op, operands, values)
        elif key is None or len(self._groups[key]) == 1:
            found = op.done(*map(values.one, operands))
            values.single.update(zip(op.results, found, strict=True))
        elif key not in self._done:
            self._done.add(key)
            rows = tuple(sorted(self._groups[key]))
            own = [ref in self.labels for ref in operands]
            given = [
                values.all(self.labels[ref][0], rows) if mine else values.one(ref)
                for ref, mine in zip(operands, own, strict=True)
            ]
            for j, stack in enumerate(op.done_to_all(given, own, len(rows))):
                values.stacks[key, j] = rows, stack


def _packs(refs: Sequence[int], labels: dict[int, Label]) -> dict[Any, dict[int, int]]:
    """Where values of several lines stand: by what they are, by line, the position."""
    found: dict[Hashable, dict[int, int]] = defaultdict(dict)
    seen: dict[int, int] = defaultdict(int)
    for position, ref in enumerate(refs):
        if ref in labels:
            pack, row = labels[ref]
            found[pack, seen[ref]][row] = position  # one value may stand there several times
            seen[ref] += 1
    return {pack: dict(sorted(rows.items())) for pack, rows in found.items() if len(rows) > 1}


def _groupable(op: _Op, own: list[bool]) -> bool:
    """Whether an operation can be done to several lines at once, for as little."""
    if op.name == "dynamic_slice":
        return not any(own[1:])
    if op.name == "dynamic_update_slice":
        return not any(own[2:])
    return op.name not in ("scan", "cond")


def _loop(op: _Op, operands: list[int], values: _Values) -> None:
    """Do a loop, which carries the values of several lines as one where it starts with several."""
    p = op.eqn.params
    a, b = p["cond_nconsts"], p["cond_nconsts"] + p["body_nconsts"]
    test, body = p["cond_jaxpr"], _Program(p["body_jaxpr"])
    read, changed = body.inputs[: b - a], body.inputs[b - a :]
    # what it only reads is laid side by side outside of it
    fixed, carried = _packs(operands[a:b], values.labels), _packs(operands[b:], values.labels)
    apart = sorted(set(range(len(changed))).difference(*(r.values() for r in carried.values())))
    kinds = [var.aval.dtype for var in p["body_jaxpr"].jaxpr.invars[b - a :]]
    labels: dict[int, Label] = {}
    labels |= {read[j]: (("read", k), r) for k, rows in fixed.items() for r, j in rows.items()}
    labels |= {changed[j]: (("now", k), r) for k, rows in carried.items() for r, j in rows.items()}
    tested = [values.one(ref) for ref in operands[:a]]
    alone_there = {
        ref: values.one(given)
        for ref, given in zip(read, operands[a:b], strict=True)
        if ref not in labels
    }
    beside = {("read", k): (tuple(r), values.all(k[0], tuple(r))) for k, r in fixed.items()}

    def spread(carry: Any) -> _Values:
        single, stacks = carry
        now = {("now", k): (tuple(r), x) for (k, r), x in zip(carried.items(), stacks, strict=True)}
        found = _Values(
            alone_there | {changed[j]: x for j, x in zip(apart, single, strict=True)}, beside | now
        )
        found.labels = labels
        return found

    def goes_on(carry: Any) -> Any:
        mine = spread(carry)
        return core.jaxpr_as_fun(test)(*tested, *(mine.one(ref) for ref in changed))[0]

    def turn(carry: Any) -> Any:
        mine = spread(carry)
        after = body.run(mine, labels)
        return (
            [jnp.asarray(mine.one(after[j]), kinds[j]) for j in apart],
            [mine.side_by_side([after[j] for j in r.values()], tuple(r)) for r in carried.values()],
        )

    start = (
        [jnp.asarray(values.one(operands[b + j]), kinds[j]) for j in apart],
        [values.all(k[0], tuple(rows)) for k, rows in carried.items()],
    )
    single, stacks = lax.while_loop(goes_on, turn, start)
    values.single |= {op.results[j]: x for j, x in zip(apart, single, strict=True)}
    for (k, rows), x in zip(carried.items(), stacks, strict=True):
        values.stacks[op.results, k] = tuple(rows), x
