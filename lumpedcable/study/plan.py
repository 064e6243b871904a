"""What runs share, and how each is stepped."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from lumpedcable.model.assemble import wave_scheme
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.ends import end_name
from lumpedcable.model.layout import Layout, make_layout
from lumpedcable.results.human import quantity
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.bodies import ANGLES
from lumpedcable.scene.run import IMPLICIT, Solver
from lumpedcable.solve.observe import Recoil
from lumpedcable.solve.plan import Plan
from lumpedcable.study.batches import outputs_at_once
from lumpedcable.study.compiled import Structure

__all__ = [
    "STEEP_START",
    "asked_step",
    "common_coordinates",
    "courant_of",
    "fields_of",
    "peaked",
    "plan_of",
    "recoil_event",
    "recoil_name",
    "recoil_names",
    "recoils_of",
    "relaxing_times",
    "rounded_steps",
    "stable_bound",
    "stepping",
    "structure_of",
    "tolerances",
]

COUNTLESS = 2.0**62  # steps in an output interval: no run gets there, but an integer can hold it
STEEP_START = (
    "expected a pitch more than 6 degrees off +-90 degrees of a body in space, where roll and yaw "
    "become one turn: choose other axes of its own (points, size, inertia, attitude and directions of "
    "clamped lines go by them), or hold its roll or yaw (free)"
)
CAPSIZES = (
    "expected a hull that rights itself, found one that turns over in {way}, its metacentric height "
    "{height}: lower its centre of gravity (above_keel), make it broader, or hold it (free, "
    "control.turn_stiffness)"
)
DEFAULT_RTOL, DEFAULT_ATOL = 1e-6, 1e-8
COURANT = {"corrected": 0.8, "viscous": 0.75}  # by the treatment of waves


def structure_of(scene: Scene) -> Structure:
    """The structure of a scene; ValueError where it cannot be laid out."""
    return Structure(scene.skeleton(), make_layout(scene, seams=True), scene)


def common_coordinates(
    study: Study, scenes: Sequence[Scene], changed: Sequence[Scene] = ()
) -> Coordinates:
    """The coordinates of all scenes together, and of those with `changed` numbers.

    Raises:
        SceneError: there are none, or not for a body, or a hull turns over in them.
    """
    try:
        found = coordinates_of(scenes, changed)
    except ValueError as error:
        raise SceneError([study.fault("dimensions", str(error))]) from None
    steep = {} if found.dimensions < 3 else {name: None for one in scenes for name in one.steep}
    if steep:
        raise SceneError([study.fault(f"bodies.{name}.attitude", STEEP_START) for name in steep])
    turns = np.abs(found.turns()).sum(axis=0) > 0.5  # all ways in space, one in a plane
    over = {
        name: CAPSIZES.format(way=way, height=quantity(height, "m", 3))
        for one in scenes
        for name, ways in one.top_heavy.items()
        for way, height in ways.items()
        if turns[ANGLES.index(way)]
    }
    if over:
        raise SceneError([study.fault(f"bodies.{name}.hull", text) for name, text in over.items()])
    return found


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


def recoil_name(recoil: Recoil) -> str:
    """ "rope.end" for the end of rope."""
    return end_name(recoil.line, recoil.node)


def recoil_names(layout: Layout) -> list[str]:
    """Names of all recoiling ends of a layout."""
    return [recoil_name(recoil) for recoil in recoils_of(layout)]


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
    rigid, fields = _rods(scene), fields_of(scene)
    return Plan(
        method="constrained" if rigid else solver.method,
        adaptive=not rigid and solver.adaptive,
        quantities=fields + ("energy",) * ("energy" in scene.output.quantities),
        recoils=recoils_of(layout),
        dtype=solver.dtype,
        max_steps=solver.max_steps or 1_000_000,
        outputs=outputs_at_once(layout, runs, fields, scene.output.fields_after),
        stop=scene.output.stop,
        tips=recoils_of(layout) if scene.output.keep != "summaries" else (),
        fields_after=scene.output.fields_after,
        watch_peaks=peaked(scene),
        borne=_borne(scene, layout),
    )


def _borne(scene: Scene, layout: Layout) -> tuple[str, ...]:
    """The pieces of lines that have a strength; the only one has it kept in any case.

    So a strength that a single line gets, or loses, is none of its program's business.
    """
    strong = {n for n, x in scene.materials.items() if x.breaking_strength is not None}
    found = (p.name for p in layout.pieces if scene.lines[p.line].material in strong)
    return tuple(found) if len(layout.pieces) > 1 else tuple(p.name for p in layout.pieces)


def peaked(scene: Scene) -> bool:
    """Whether the largest tensions of elastic lines are those of any step: leapfrog knows them."""
    return scene.solver.method == "leapfrog" and not scene.output.static and not _rods(scene)


def _rods(scene: Scene) -> bool:
    return any(scene.materials[x.material].law == "inextensible" for x in scene.lines.values())


def fields_of(scene: Scene) -> tuple[str, ...]:
    """The fields that a scene keeps of every line."""
    kept = scene.output.quantities if scene.output.keep == "fields" else ()
    bends = any(line.bending is not None for line in scene.lines.values())
    others = ("energy",) if bends else ("energy", "bending_moment")
    return tuple(quantity for quantity in kept if quantity not in others)


def stable_bound(
    scene: Scene, bound: np.ndarray, swept: Mapping[str, np.ndarray] = MappingProxyType({})
) -> np.ndarray:
    """The largest stable step (s) of each run by its method, from that of leapfrog."""
    times = (swept.get(key, time) for key, time in relaxing_times(scene).items())
    return np.minimum.reduce([bound, *(np.broadcast_to(time, bound.shape) for time in times)])


def relaxing_times(scene: Scene) -> dict[str, Any]:
    """The times (s) of what relaxes in a scene, by key, that steps of its method may not exceed.

    Leapfrog and implicit methods follow what relaxes at any step.
    """
    if scene.solver.method in ("leapfrog", *IMPLICIT):
        return {}
    used = {line.material for line in scene.lines.values()}
    return {
        f"materials.{name}.relaxation.{one}.time": branch.time
        for name in sorted(used)
        for one, branch in scene.materials[name].relaxation.items()
    }


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
