"""Forces and masses of the whole scene at an instant, lines and what acts between them."""

from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.attached import follow
from lumpedcable.model.boundary import boundary
from lumpedcable.model.couple import Found, live_line, reel_of
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.line import Line, Workspace
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.passing import drifting, hastened, passed
from lumpedcable.model.reels import Drum
from lumpedcable.model.splices import add_splices
from lumpedcable.model.turned import turned
from lumpedcable.physics.load import Shape

__all__ = ["evaluate", "node_frame"]


def evaluate(
    model: Model,
    t: Float[Array, ""],
    displacement: Vectors,
    velocity: Vectors | None,
    reaction: dict[str, Float[Array, " d"]],
    dt: Float[Array, ""] | None = None,
    over: dict[str, Workspace] | None = None,
) -> Found:
    """Forces and inertia of every line at t (s), before ends and junctions constrain them.

    With velocity None: at rest, as statics asks. `dt` (s) is the fixed step, if any; `over` are
    workspaces of an earlier evaluation to write over.
    """
    result = Found()
    displacement = follow(model, t, displacement)
    model = turned(model, t, displacement)
    for name in model.lines:
        line = live_line(model, name, displacement, velocity)
        if dt is not None:
            dt = dt.astype(line.reference.dtype)
        boundaries = tuple(boundary(model, name, node, t, reaction) for node in line.ends)
        ends = tuple(met.force for met in boundaries)
        u = displacement[name]
        v = None if velocity is None else velocity[name]
        workspace = None if over is None else over[name]
        forces = line.forces(u, v, boundaries, dt, ends, workspace)
        wet = line.wet(forces.shape, None if velocity is None else t)
        nodes = node_frame(model, line, forces.shape, wet)
        reel, past, slower = reel_of(model, name), None, None
        resisted = line.drag is not None or line.grip is not None
        if reel is not None and line.growth is not None and resisted:
            past = line.growth * passed(forces.shape, reel.node)
            nodes = nodes if line.drag is None else drifting(nodes, past)
        push = None
        if line.sea is not None and velocity is not None:
            water, surge = line.sea.motion(t, forces.shape.position)
            push = inertia.wave_push(line, nodes, surge, wet)
            if line.lift is not None:
                push = push + line.lift.of(wet) - line.lift.force(forces.shape)
            forces = forces._replace(force=forces.force + push)
            nodes = inertia.in_waves(nodes, water)
        if isinstance(reel, Drum) and velocity is not None:
            slower = hastened(reel, forces.shape, nodes, t, dt)
            forces = forces._replace(force=forces.force + slower)
        result[name] = Evaluation(
            forces, nodes, ends, boundaries, push=push, past=past, hastened=slower
        )
    add_splices(model, t, result, dt)
    result.add_couplings(model, t, displacement, velocity, dt)
    return result


def node_frame(
    model: Model, line: Line, shape: Shape, wet: Float[Array, " nodes"] | None = None
) -> inertia.Frame:
    """Inertia and resistance of the nodes of a line, in the current at their heights.

    `wet` is how long each is under water (m), where that is not as in water at rest.
    """
    height = None
    if model.up is not None and model.base is not None and line.current is not None:
        height = model.base + model.up @ shape.position
    return inertia.frame(line, shape, height, wet)
