"""Natural modes about shapes known in closed form, or about the engine's own equilibrium."""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from engine_runs import scene_of, study_of

from lumpedcable.model.assemble import assemble
from lumpedcable.model.attached import follow
from lumpedcable.model.bodies import body_key
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.model.line import placed
from lumpedcable.model.motion import acceleration
from lumpedcable.model.net import make_net
from lumpedcable.solve.modal import natural_modes
from lumpedcable.solve.targets import rest_of
from lumpedcable.study.compiled import RUN_ONCE, Structure, linearise
from lumpedcable.study.modes import find_modes

# two fixed ends 105 m apart: 5 % strain, 50 kN, in as many dimensions as a test asks for
STRING = """
[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "hooke"
length = "100 m"
segments = 32
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = [105, 0, 0] }

[output]
duration = 1
every = 1
"""


def straight(length, segments, direction=(1.0, 0.0, 0.0)):
    """Nodes (n + 1, 3) in m on a straight line from the origin."""
    return np.linspace(0.0, length, segments + 1)[:, None] * np.asarray(direction, float)


@partial(jax.jit, static_argnames=("structure",))
def _placed(structure, axes, origin, numbers, places):
    scene = structure.scene.with_numbers(numbers)
    model = assemble(scene, structure.layout, Coordinates(axes, origin))
    lines = {name: placed(line, places[name]) for name, line in model.lines.items()}
    return eqx.tree_at(lambda m: m.lines, model, lines)


def model_at(scene, nodes):
    """The model of a scene with its lines at given places (nodes, 3) in m, by line of the model."""
    layout, coordinates = make_layout(scene), coordinates_of([scene])
    places = {
        name: coordinates.axes.T @ (np.asarray(x) - coordinates.origin).T
        for name, x in nodes.items()
    }
    structure = Structure(scene.skeleton(), layout, scene)
    model = _placed(structure, *coordinates, scene.numbers(), places)
    return model, layout, coordinates


def modes_at(folder, text, nodes, *overrides, count=4):
    """Modes of a scene text about given places of its only line, (nodes, 3), or of all by name."""
    scene = scene_of(folder, text, *overrides)
    if not isinstance(nodes, dict):
        nodes = {next(iter(scene.lines)): nodes}
    model, layout, coordinates = model_at(scene, nodes)
    return natural_modes(linearise(model), make_net(model), layout, coordinates, count)


def at_rest(scene):
    """The scene's state of rest, its bodies where they have settled."""
    coordinates = coordinates_of([scene])
    layout, numbers = make_layout(scene), scene.numbers()

    @partial(jax.jit, compiler_options=RUN_ONCE)
    def rest(numbers):
        return rest_of(scene.with_numbers(numbers), layout, coordinates)

    return rest({key: jnp.asarray(value, float) for key, value in numbers.items()})


def slopes_of_dynamics(model, bodies, held=()):
    """-da/dx of the dynamics at rest, of free nodes and then of bodies by name.

    `held` are coordinates that stay, (body, number).
    """
    net = make_net(model)
    free = np.flatnonzero(~net.fixed)
    still = {name: jnp.zeros_like(line.reference) for name, line in model.lines.items()}
    still |= {body_key(n): jnp.zeros_like(body.reference) for n, body in model.bodies.items()}
    ways = [
        (body_key(name), k)
        for name in bodies
        for k in range(model.bodies[name].reference.size)
        if (name, k) not in held
    ]
    d = next(iter(model.lines.values())).dimensions
    count = free.size * d

    def unpacked(x):
        places = jnp.zeros((net.size, d)).at[free].set(x[:count].reshape(-1, d))
        moved = {**still, **net.spread(places)}
        for (key, k), step in zip(ways, x[count:], strict=True):
            moved[key] = moved[key].at[k].set(step)
        return follow(model, jnp.zeros(()), moved)

    @partial(jax.jit, compiler_options=RUN_ONCE)
    def gain(x):
        found, _ = acceleration(model, jnp.zeros(()), unpacked(x), still, {})
        nodes = net.pick({name: found[name] for name in model.lines})[free]
        own = [found[key][k][None] for key, k in ways]
        return jnp.concatenate([nodes.ravel(), *own])

    return -jax.jacfwd(gain)(jnp.zeros(count + len(ways)))


def line_on_a_winch(material, drive=""):
    """A wire of 1 MN and 2 kg/m, 12 m between post and winch (30 kg), which stretches it by 5 %.

    `material` are more keys of its material, `drive` of the winch, each after a comma.
    """
    return f"""
dimensions = 1

[materials.steel]
law = "linear"
EA = "1 MN"
{material}

[lines.wire]
material = "steel"
length = "10 m"
segments = 5
mass = "2 kg/m"
start = {{ fixed = [0, 0, 0] }}
end.winch = {{ at = [12, 0, 0], tension = "50 kN", inertia = 30{drive} }}

[output]
duration = 1
every = 1
"""


def springs_on_a_winch(n, stretch):
    """How far each of n equal springs in a row between two held points is stretched (m), (n, n).

    By the n - 1 places between them, and by what a winch pays out, which is shared by all of them.
    """
    ways = np.zeros((n, n))
    ways[:, n - 1] = -stretch / n
    ways[:-1, : n - 1] += np.eye(n - 1)
    ways[1:, : n - 1] -= np.eye(n - 1)
    return ways


def modes_of(folder, text, *overrides, count=4, run=0):
    """Modes of a scene text about the equilibrium that the engine finds."""
    return find_modes(study_of(folder, text, *overrides), count, run)
