"""Natural modes of one run of a study, at its static equilibrium."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import posts_of
from lumpedcable.model.layout import layout_of
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net, make_net
from lumpedcable.model.numbers import number
from lumpedcable.physics.coupling import BodyPost, IdealCable
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody
from lumpedcable.scene.ends import JoinedEnd
from lumpedcable.solve.carried import is_carried
from lumpedcable.solve.modal import Modes, natural_modes
from lumpedcable.solve.modal_carried import carried_rest
from lumpedcable.solve.modal_linear import Linear
from lumpedcable.solve.modal_relaxing import Relaxing, kinds_of
from lumpedcable.solve.statics import force_scale, static_residual
from lumpedcable.status import ADVICE, MEANING, Status
from lumpedcable.study.compiled import Structure, damping_of, linearise, prepare_batch, stiffer_of
from lumpedcable.study.plan import common_coordinates

__all__ = ["NoEquilibriumError", "find_modes"]


EDGES = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 5, 1, 3, 7, 6, 2)
"""A way over all edges of a box: a bit for each side of its corners."""
IN_BALANCE = 1e-6  # of the largest force: a place in a file, of some digits, leaves that on a joint
ROOM = {
    1: "inextensible lines on one straight line move across it alone",
    2: "inextensible lines that hold each other in this plane move out of it alone",
}


class NoEquilibriumError(ValueError):
    """Statics found no equilibrium to vibrate about; the message says what to do."""


def find_modes(study: Study, count: int, run: int = 0) -> Modes:
    """The `count` lowest natural modes of run number `run` of a study.

    Raises:
        SceneError: the scene cannot be laid out; nothing can move, or not in the dimensions that it
            is computed in.
        NoEquilibriumError: it has no static equilibrium that could be found.
    """
    scene = _hung(study.runs[run])
    layout = layout_of(study, scene)
    coordinates = common_coordinates(study, [scene])
    numbers = {key: number(value) for key, value in scene.numbers().items()}
    # a batch needs something that may differ between its runs
    swept = {"output.duration": np.array([scene.output.duration])}
    ready = prepare_batch(
        Structure(scene.skeleton(), layout, scene), "float64",
        coordinates.axes, coordinates.origin,
        {key: value for key, value in numbers.items() if key not in swept}, swept,
    )  # fmt: skip
    if not bool(ready.converged[0]):
        status = Status.STATICS_NOT_CONVERGED
        raise NoEquilibriumError(
            f"{MEANING[status]} (forces out of balance by {float(ready.imbalance[0]):.1e} of the "
            f"largest): {ADVICE[status]}"
        )
    model = jax.tree.map(lambda x: np.asarray(x)[0], ready.model)
    net = make_net(model)
    outlines = {name: _outline(scene, name) @ coordinates.axes for name in scene.settling}
    try:
        damped = partial(damping_of, model) if _is_damped(model) else None
        linear = linearise(model, outlines)
        found = natural_modes(
            linear, net, layout, coordinates, count, damped, _relaxing(model, outlines, linear)
        )
    except ValueError as error:
        d = coordinates.dimensions
        if d == 3 or net.fixed.all():
            raise SceneError([study.fault("lines", str(error))]) from None
        message = f"expected {'2 or ' if d == 1 else ''}3 for natural modes, found {d}: {ROOM[d]}"
        raise SceneError([study.fault("dimensions", message)]) from None
    if any(line.inextensible for line in model.lines.values()):
        found = replace(found, damping=None)  # rods keep no account of theirs
    nodes, shapes = _ideal_lines(scene, model, coordinates, found)
    return replace(
        found,
        nodes=found.nodes | nodes,
        shapes=found.shapes | shapes,
        held=_held(scene, model, net),
    )


def _is_damped(model: Model) -> bool:
    """Whether anything may resist small motions in proportion; rods take part in no such account."""
    lines = model.lines.values()
    if any(line.inextensible for line in lines):
        return False
    return any(
        line.damping is not None
        or line.resistances
        or (line.drag is not None and line.current is not None)
        for line in lines
    ) or any(body.works() for body in model.bodies.values())


def _relaxing(model: Model, outlines: dict[str, np.ndarray], linear: Linear) -> Relaxing | None:
    """What the branches of its materials add to the stiffness of a model; None where there are none."""
    times, shares = kinds_of(model)
    if not times.size:
        return None
    fast, slow = jax.device_get((stiffer_of(model, outlines, shares), linear.stiffness))
    return Relaxing(times, jax.tree.map(np.subtract, fast, slow))


def _hung(scene: Scene) -> Scene:
    """The scene with trolleys at rest that it lets go from a height."""
    bodies = {
        name: body.model_copy(update={"height": None}) if isinstance(body, CarriedBody) else body
        for name, body in scene.bodies.items()
    }
    return scene.model_copy(update={"bodies": bodies})


def _ideal_lines(
    scene: Scene, model: Model, coordinates: Coordinates, found: Modes
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Ideal lines at rest (3, 3) in m, from post to trolley to post, and how they move in each mode."""
    nodes, shapes = {}, {}
    turns = np.asarray(coordinates.turns())
    for coupled in model.couplings:
        posts = posts_of(model, coupled, jnp.zeros(()), None, None)
        body = scene.bodies[coupled.body]
        if posts is None or not isinstance(body, CarriedBody):
            continue
        assert isinstance(coupled.law, IdealCable)  # it alone has posts
        ends = [coordinates.expand(np.asarray(p.place), 0, place=True) for p in posts]
        own = found.rigid[coupled.body]
        nodes[body.on.line] = np.stack([ends[0], own.position, ends[1]])
        moved = np.zeros((own.moved.shape[0], 3, 3))
        moved[:, 1] = own.moved[:, :3]
        for k, post in zip((0, 2), (coupled.law.start, coupled.law.end), strict=True):
            if isinstance(post, BodyPost) and post.body in found.rigid:
                ship, by = model.bodies[post.body], found.rigid[post.body].moved
                goes = jax.jacfwd(ship.place)(jnp.asarray(ship.reference), post.point)
                q = np.concatenate([by[:, :3] @ coordinates.axes, by[:, 3:] @ turns.T], axis=1)
                moved[:, k] = q @ np.asarray(goes).T @ coordinates.axes.T
        shapes[body.on.line] = moved
    return nodes, shapes


def _outline(scene: Scene, name: str) -> np.ndarray:
    """A way (p, 3) in m, along a body's own axes, by which it is drawn.

    The edges of its size; otherwise from its centre to each of its points, and to where its mass
    would have to be to turn as it does.
    """
    body = scene.bodies[name]
    assert isinstance(body, Body)  # no other settles
    if body.size is not None:
        bits = np.array(EDGES)[:, None] >> np.array([2, 1, 0]) & 1
        return (bits - 0.5) * body.size
    tips = [np.asarray(point, float) for point in body.points.values()]
    if body.turns and body.inertia is not None:
        arm = np.sqrt(max(body.inertia) / body.mass)
        tips += [*(arm * np.eye(3)), *(-arm * np.eye(3))]
    return np.concatenate([np.zeros((1, 3)), *([tip, np.zeros(3)] for tip in tips)])


def _held(scene: Scene, model: Model, net: Net) -> float:
    """Net force (N) on joints that are held at a place while the start is found; 0 where they stay."""
    ends = (end for line in scene.lines.values() for end in (line.start, line.end))
    if not any(isinstance(end, JoinedEnd) and end.at is not None for end in ends):
        return 0.0
    if is_carried(model):
        force = carried_rest(model, net)
    else:
        still = jnp.zeros((net.size, next(iter(model.lines.values())).dimensions))
        force = static_residual(model, still, net)
    left = float(jnp.max(jnp.linalg.norm(force, axis=1)))
    return left if left > IN_BALANCE * float(force_scale(model)) else 0.0
