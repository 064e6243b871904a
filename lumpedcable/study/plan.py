"""Which runs go together, and how each is stepped."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np

from lumpedcable.model.assemble import wave_scheme
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import Layout, make_layout
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.run import Solver
from lumpedcable.solve.integrate import Plan
from lumpedcable.solve.observe import Recoil
from lumpedcable.study.compiled import Structure

__all__ = [
    "COMPILING",
    "GPU_LANES",
    "LANES",
    "asked_step",
    "batch_sizes",
    "common_coordinates",
    "courant_of",
    "lane_time",
    "lanes",
    "peaked",
    "plan_of",
    "recoil_event",
    "recoils_of",
    "rounded_steps",
    "sizes_for",
    "stepping",
    "steps_at_once",
    "structure_of",
    "tolerances",
]

LANES = 64  # runs that are advanced together on each core, whose cache their states stay in,
GPU_LANES = 1024  # and on each GPU, where fewer would wait for kernels to start: a shard's
MANY = 1024  # runs beyond which filling up batches costs less than compiling for their sizes
COMPILING = 10.0  # s: what a batch of another size costs before it starts, most of it compiling
CALL = 8  # lanes that take as long as what a batch takes besides them
NODE_STEP = 1e-7  # s, roughly: what a step of a node takes with all that belongs to it
ROOM = 2**23  # bytes of outputs in one call: more of them wait for fresh memory from the system
CALL_TIME = 5.0  # s, by NODE_STEP: what a call takes at most, far less than that most often
COUNTLESS = 2.0**62  # steps in an output interval: no run gets there, but an integer can hold it
OUTPUTS = (3, 8)  # powers of two: least and most outputs in one call
STEEP_START = (
    "expected a pitch more than 6 degrees off +-90 degrees of a body in space, where roll and yaw "
    "become one turn: choose other axes of its own (points, size, inertia and attitude go by them), or "
    "hold its roll or yaw (free)"
)
DEFAULT_RTOL, DEFAULT_ATOL = 1e-6, 1e-8
COURANT = {"corrected": 0.8, "viscous": 0.75}  # by the treatment of waves
ADAPTIVE = {"heun", "midpoint", "ralston", "bosh3", "tsit5", "dopri5", "dopri8",
            "kvaerno3", "kvaerno4", "kvaerno5"}  # fmt: skip


def structure_of(scene: Scene) -> Structure:
    """The structure of a scene; ValueError where it cannot be laid out."""
    return Structure(scene.skeleton(), make_layout(scene, seams=True), scene)


def common_coordinates(
    study: Study, scenes: Sequence[Scene], changed: Sequence[Scene] = ()
) -> Coordinates:
    """The coordinates of all scenes together, and of those with `changed` numbers.

    Raises:
        SceneError: there are none, or not for a body.
    """
    try:
        found = coordinates_of(scenes, changed)
    except ValueError as error:
        raise SceneError([study.fault("dimensions", str(error))]) from None
    steep = {} if found.dimensions < 3 else {name: None for one in scenes for name in one.steep}
    if steep:
        raise SceneError([study.fault(f"bodies.{name}.attitude", STEEP_START) for name in steep])
    return found


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


def _nodes(layout: Layout) -> int:
    return 1 + sum(piece.segments + 1 for piece in layout.pieces)


def recoils_of(layout: Layout) -> tuple[Recoil, ...]:
    """Every end that recoils when its event comes: the broken one, and where it was all that held its
    partner, that too.
    """
    found: list[Recoil] = []
    for name, node, _ in layout.breaks:
        index = layout.joint_of(name, node)
        joint = None if index is None else layout.joints[index]
        members = ((name, node),) if joint is None or not joint.parts else joint.members
        for member in members:
            if Recoil(*member) not in found:
                found.append(Recoil(*member))
    return tuple(found)


def recoil_event(layout: Layout, recoil: Recoil) -> str:
    """Name of the event at which an end recoils: what breaks it or, at its joint, its partner."""
    index = layout.joint_of(recoil.line, recoil.node)
    own = (recoil.line, recoil.node)
    members = () if index is None else layout.joints[index].members
    events = [layout.event_at(*member) for member in (own, *members)]
    return next(event for event in events if event is not None)


def courant_of(scene: Scene) -> float:
    """The step over the largest stable one, where a scene gives no step: its choice or what it needs.

    A viscosity that makes heat of a shock needs room between its own bound and that of the line's
    stiffness: at 0.74 that bound, 0.4 (1 - nu^2)(3 - nu^2) c / (6 nu), still leaves 0.1 c for the
    viscosity of `ReleaseWaves`. With less room the lumps that a front has picked up go on jostling, and
    loads peak 2 to 3 % too high on any mesh. The corrected chain needs less of it; but at 0.9 the
    profile behind a break at once from 450 kN stays 0.5 % off on any mesh, at 0.8 it converges.
    """
    if "courant" in scene.solver.model_fields_set:
        return scene.solver.courant
    return COURANT.get(wave_scheme(scene), scene.solver.courant)


def plan_of(scene: Scene, layout: Layout, runs: int = 1) -> Plan:
    """The plan of `runs` runs: fixed steps for leapfrog and Euler or where a step is asked for."""
    solver = scene.solver
    rigid = _rods(scene)
    fixed = solver.step is not None or "courant" in solver.model_fields_set
    return Plan(
        method="constrained" if rigid else solver.method,
        adaptive=not rigid and solver.method in ADAPTIVE and not fixed,
        quantities=fields_of(scene) + ("energy",) * ("energy" in scene.output.quantities),
        recoils=recoils_of(layout),
        dtype=solver.dtype,
        max_steps=solver.max_steps or 1_000_000,
        outputs=_outputs_at_once(scene, layout, runs),
        stop=scene.output.stop,
        tips=recoils_of(layout) if scene.output.keep != "summaries" else (),
        fields_after=scene.output.fields_after,
        watch_peaks=peaked(scene),
    )


def peaked(scene: Scene) -> bool:
    """Whether the largest tensions of elastic lines are those of any step: leapfrog knows them."""
    return scene.solver.method == "leapfrog" and not scene.output.static and not _rods(scene)


def _rods(scene: Scene) -> bool:
    return any(scene.materials[x.material].law == "inextensible" for x in scene.lines.values())


def fields_of(scene: Scene) -> tuple[str, ...]:
    """The fields that a scene keeps of every line."""
    kept = scene.output.quantities if scene.output.keep == "fields" else ()
    return tuple(quantity for quantity in kept if quantity != "energy")


def _outputs_at_once(scene: Scene, layout: Layout, runs: int) -> int:
    """Outputs that one call may return: a power of two, as many as fit into `ROOM`.

    Few calls, since each costs as much as a hundred steps of a short line.
    """
    per_node = {"position": 3, "velocity": 3, "tension": 1, "strain": 1}
    fields = sum(per_node.get(quantity, 0) for quantity in fields_of(scene))
    numbers = fields / scene.output.fields_after + 1
    most = ROOM / (8.0 * runs * _nodes(layout) * numbers)
    return int(2 ** np.clip(np.floor(np.log2(most)), *OUTPUTS))


def asked_step(
    scene: Scene, bound: np.ndarray, swept: Mapping[str, np.ndarray] = MappingProxyType({})
) -> np.ndarray:
    """The step (s) that each run asks for: its own, or a share of the largest stable one, `bound`."""
    step = swept.get("solver.step", scene.solver.step)
    if step is None:
        step = swept.get("solver.courant", courant_of(scene)) * bound
    return np.broadcast_to(step, bound.shape)


def rounded_steps(
    scene: Scene, bound: np.ndarray, swept: Mapping[str, np.ndarray] = MappingProxyType({})
) -> np.ndarray:
    """Steps per output interval for each run, from its own bound on the step (s).

    `swept` are the runs' own numbers by key, of which a step or a Courant number is obeyed. A run's
    steps must not depend on which runs it shares a batch with, and few distinct numbers make few
    batches: beyond 16, numbers are rounded up to five significant bits, at most 6 % more. What an
    integer cannot hold becomes `COUNTLESS`.
    """
    if scene.output.static:
        return np.ones(bound.shape, int)
    with np.errstate(divide="ignore", over="ignore"):
        count = np.ceil(scene.output.every / asked_step(scene, bound, swept) * (1.0 - 1e-9))
    count = np.where(np.isnan(count), 1.0, np.clip(count, 1.0, COUNTLESS))
    unit = 2.0 ** np.maximum(np.floor(np.log2(count)) - 4.0, 0.0)
    return (np.ceil(count / unit) * unit).astype(int)


def stepping(
    scene: Scene, layout: Layout, bound: np.ndarray, swept: Mapping[str, np.ndarray]
) -> np.ndarray:
    """How each run is stepped, shape (runs, 3): steps per output interval, rtol, atol.

    Runs go through time together where these are the same. Arguments as of `rounded_steps`.
    """
    steps = rounded_steps(scene, bound, swept)
    if plan_of(scene, layout).adaptive:
        steps = np.ones_like(steps)
    rtol, atol = (
        np.broadcast_to(swept.get(f"solver.{key}", value), bound.shape)
        for key, value in zip(("rtol", "atol"), tolerances(scene.solver), strict=True)
    )
    return np.stack([steps, rtol, atol], axis=-1)


def tolerances(solver: Solver) -> tuple[float, float]:
    """The relative and the absolute tolerance of adaptive methods."""
    return solver.rtol or DEFAULT_RTOL, solver.atol or DEFAULT_ATOL
