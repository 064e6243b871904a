"""The compiled programs of a study: statics, start and advance, each over a batch of runs.

They are keyed by structure alone. Every number of the scene is an argument, so that another
pretension or another number of steps finds the program already compiled, in this process or, through
the persistent cache, in the next.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import platformdirs
from jax.extend import core
from jaxtyping import Array, Bool, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.line import alike
from lumpedcable.model.model import Model
from lumpedcable.model.seams import cut_at
from lumpedcable.physics.precision import cast
from lumpedcable.scene import Scene
from lumpedcable.solve.bound import step_bound
from lumpedcable.solve.clamps import folded
from lumpedcable.solve.integrate import advance, begin
from lumpedcable.solve.modal_damping import modal_damping
from lumpedcable.solve.modal_linear import linearised
from lumpedcable.solve.modal_relaxing import stiffer
from lumpedcable.solve.observe import Sample
from lumpedcable.solve.plan import Numbers, Plan
from lumpedcable.solve.targets import rest_of
from lumpedcable.study.alike import together
from lumpedcable.study.devices import platform, shared_out
from lumpedcable.study.kept import kept, program
from lumpedcable.study.lanes import across
from lumpedcable.study.packed import Packed, pack
from lumpedcable.study.whole import keep_whole

__all__ = [
    "RUN_OFTEN",
    "RUN_ONCE",
    "Ready",
    "Structure",
    "advance_batch",
    "begin_batch",
    "configure",
    "damping_of",
    "linearise",
    "prepare_batch",
    "prepare_cells",
    "prepare_many",
    "stiffer_of",
    "understood",
]

CACHE_VARIABLE = "LUMPEDCABLE_CACHE"
# Of a loop whose turn touches fewer bytes than this the CPU's compiler makes one function instead of a
# list of small ones to call; a step of a short line then takes half the time.
WHOLE_LOOPS = ("--xla_backend_extra_options", "xla_cpu_small_while_loop_byte_threshold=268435456")


def configure() -> None:
    """Float64, calls without threads, loops compiled whole, programs kept for the next process.

    They are in the user's cache folder; LUMPEDCABLE_CACHE names another one, or "off". Who has options
    of that kind in XLA_FLAGS keeps them; a process that has used jax already has read its own.
    """
    jax.config.update("jax_enable_x64", True)
    # a call waits for its numbers at once: to hand it to another thread takes longer than a short one
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    flags, (name, value) = os.environ.get("XLA_FLAGS", ""), WHOLE_LOOPS
    if name not in flags:
        os.environ["XLA_FLAGS"] = f"{flags} {name}={value}".strip()
    folder = os.environ.get(CACHE_VARIABLE) or platformdirs.user_cache_dir("lumpedcable")
    if folder.lower() == "off":
        return
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError:
        return  # a cache is a convenience: without one everything works, only slower
    jax.config.update("jax_compilation_cache_dir", folder)
    # the smallest too, each of which would take 30 ms at every start
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


configure()
keep_whole()

ON_CPU = platform() == "cpu"


def understood(options: dict[str, Any]) -> dict[str, Any] | None:
    """Options of the CPU's compiler, or None where this version of it does not know them."""
    if not ON_CPU:
        return None
    try:
        jax.jit(lambda: 0, compiler_options=options)()
    except jax.errors.JaxRuntimeError:
        return None
    return options


# The compiler's newer way from fused operations to machine code takes a third longer to the same speed.
OLDER_WAY = {"xla_cpu_use_fusion_emitters": False}
# Statics and start run once: compiling them takes longer than running them ever will, so that the
# compiler is asked not to try hard.
PLAINLY = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
RUN_ONCE = understood(PLAINLY | OLDER_WAY) or understood(PLAINLY)
# A study's start runs for hundreds of lanes, several times in each structure: in a sixth of the time,
# for some tenths of a second more of compiling.
RUN_SELDOM = None if RUN_ONCE is None else RUN_ONCE | {"xla_backend_optimization_level": 1}
# Sums of a hundred numbers go to a library for large ones otherwise; steps of 64 lines take a fifth
# less time without it.
SMALL_SUMS = {"xla_cpu_experimental_ynn_fusion_type": ""}
RUN_OFTEN = understood(SMALL_SUMS | OLDER_WAY) or understood(SMALL_SUMS)

FEW_RUNS = 64  # that are brought to rest, and begun, one after the other


@dataclass(frozen=True)
class Structure:
    """What two runs must share to share a compiled program; `scene` is any one that has it."""

    skeleton: str
    layout: Layout
    scene: Scene = field(compare=False, repr=False)


BALANCED = 1e-6
"""Largest force left over that of the scene up to which a state that is refused is told to balance."""


class Ready(NamedTuple):
    """A batch of runs ready to move: models at rest, step bounds (s), how statics went.

    `overturned`: what was found is in balance, but no state to begin with, since a touch turns it over.
    """

    packed: Packed
    bound: Float[Array, " runs"]
    converged: Bool[Array, " runs"]
    imbalance: Float[Array, " runs"]
    overturned: Bool[Array, " runs"]

    @property
    def model(self) -> Model:
        """The models, every array with an axis of runs before its own."""
        return Packed(np.asarray(self.packed.numbers), self.packed.form).tree()


def _prepare(
    structure: Structure,
    dtype: str,
    axes: Float[Array, "3 d"],
    origin: Float[Array, " 3"],
    shared: Mapping[str, Float[Array, ""]],
    swept: Mapping[str, Float[Array, " runs"]],
    beside: Mapping[str, Float[Array, "runs more"]] = MappingProxyType({}),
) -> Ready:
    """Static equilibria of a batch: `swept` numbers differ between runs, `shared` ones do not.

    With `beside`, each of the runs is many that differ in these numbers too, and the result has
    runs * more. What does not depend on them, most often the whole search for the equilibrium, is
    done once for all of these.
    """

    def one(mine, shared, axes, origin):
        coordinates = Coordinates(axes, origin)
        scene = structure.scene.with_numbers({**shared, **mine})
        found = rest_of(scene, structure.layout, coordinates)
        bound = step_bound(found.model)
        balanced = ~found.converged & (found.imbalance <= BALANCED)
        return Ready(
            pack(cast(found.model, dtype)), bound, found.converged, found.imbalance,
            balanced & folded(found.model),
        )  # fmt: skip

    common = dict(shared), axes, origin
    told = "prepare", structure, dtype
    if not beside:
        return shared_out(partial(kept, each(one), told), (dict(swept),), common)
    # followed once, for a run alone: under two maps each of its operations takes twice as long
    example = jax.tree.map(lambda x: x[0], dict(swept)) | {k: x[0, 0] for k, x in beside.items()}
    again, _ = followed(one, example, *common)

    def cell(mine, beside, *common):
        return jax.vmap(lambda own: again({**mine, **own}, *common))(beside)

    every = jax.vmap(cell, in_axes=(0, 0, None, None, None))
    every_one = partial(kept, every, told)
    found = shared_out(every_one, (dict(swept), dict(beside)), common)
    return jax.tree.map(lambda x: x.reshape(x.shape[0] * x.shape[1], *x.shape[2:]), found)


# a few runs; many; with `beside`
prepare_batch, prepare_many, prepare_cells = (
    jax.jit(_prepare, static_argnames=("structure", "dtype"), compiler_options=options)
    for options in (RUN_ONCE, RUN_SELDOM, RUN_SELDOM)
)


@partial(jax.jit, static_argnames=("plan",), compiler_options=RUN_ONCE)
def begin_batch(models: Packed, plan: Plan, numbers: Numbers) -> tuple[Packed, Packed]:
    """States and samples at the start of every run."""

    def every(models, numbers):
        def one(model):
            mine = cut_at(model.tree(), numbers.cuts)
            run, found = together(lambda m: begin(m, plan, numbers), alike(mine.lines), mine)
            return pack(run), pack(found)

        return in_one_piece(plan, numbers.steps > 0, each(one), models)

    return shared_out(partial(kept, every, ("begin", plan)), (models,), (numbers,))


@partial(jax.jit, static_argnames=("plan",), donate_argnames=("runs",), compiler_options=RUN_OFTEN)
def advance_batch(
    models: Packed, plan: Plan, numbers: Numbers, runs: Packed, first: Array, count: Array,
    ends: tuple[Array, Array] | None = None,
) -> tuple[Packed, Packed | Sample]:  # fmt: skip
    """The next `count` outputs of every run: states, samples with an axis of outputs.

    `ends` are as of `advance`; without them it is another program, which counts less. Samples are packed
    for a single run alone, where all have fields: to lay those of many together takes longer than calls.
    """

    def every(models, runs, numbers, first, count, ends):
        alone = models.numbers.shape[0] == 1 and plan.fields_after == 1
        keep = pack if alone else None

        def moved(mine, run):
            return advance(mine, plan, numbers, run, first, count, keep, ends)

        def one(model, run):
            mine = cut_at(model.tree(), numbers.cuts)
            run, found = together(moved, alike(mine.lines), mine, run.tree())
            return pack(run), found

        if models.tree().rigid:  # steps long enough, and functions shorter
            return across(one, models, runs)
        return in_one_piece(plan, count >= 0, partial(across, one), models, runs)

    every_one = partial(kept, every, ("advance", plan))
    return shared_out(every_one, (models, runs), (numbers, first, count, ends))


def each(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function of one run for all of a batch, which is its first argument, the runs first.

    A CPU goes through a few runs one after the other. Under a map each loop goes on until the last run
    is through, with a choice for every number of which runs still do: twice as much to be followed, and
    for runs that do not end together twice the time. What many runs gain by vectors is more than that.
    """

    def all_of(batch, *common):
        runs = jax.tree.leaves(batch)[0].shape[0]
        if runs == 1:
            found = function(jax.tree.map(lambda x: x[0], batch), *common)
            return jax.tree.map(lambda x: jnp.asarray(x)[None], found)
        if ON_CPU and runs <= FEW_RUNS:
            return jax.lax.map(lambda mine: function(mine, *common), batch)
        return jax.vmap(lambda mine: function(mine, *common))(batch)

    return all_of


def in_one_piece(
    plan: Plan, sure: Bool[Array, ""], function: Callable[..., Any], *batches: Packed
) -> Any:
    """`function(*batches)`, to be traced: of a single run the CPU makes one function of it.

    Else it has a list of some hundred small ones to call, each for a handful of numbers, which takes as
    long as thirty steps of a short line; many runs, or a constrained step, have more to do than that.
    Loops are compiled whole (`WHOLE_LOOPS`), so that this is one of a single turn: `sure` is true, but
    only who calls knows.
    """
    if not ON_CPU or batches[0].numbers.shape[0] > 1 or plan.method == "constrained":
        return function(*batches)
    again, shapes = followed(function, *batches)
    empty = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes)

    def once(_):
        return jnp.zeros((), bool), again(*batches)

    return jax.lax.while_loop(lambda carry: carry[0], once, (sure, empty))[1]


def followed(function: Callable[..., Any], *examples: Any) -> tuple[Callable[..., Any], Any]:
    """`function`, followed once for arguments like the examples; and the shapes of its result."""
    closed, shapes = jax.make_jaxpr(function, return_shape=True)(*examples)
    flat, form = core.jaxpr_as_fun(closed), jax.tree.structure(shapes)
    return lambda *given: jax.tree.unflatten(form, flat(*jax.tree.leaves(given))), shapes


linearise = program(linearised, options=RUN_ONCE)
"""Stiffness and masses of one model at rest, for its natural modes."""
damping_of = program(modal_damping, options=RUN_ONCE)
"""What damps natural modes of a model at rest."""
stiffer_of = program(stiffer, options=RUN_ONCE)
"""Its stiffness where branches of materials that relax hold fast."""
