"""Tension laws by the name that the scene language gives them: the one place where they meet."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.numbers import number, vector
from lumpedcable.physics.relaxation import Relaxation
from lumpedcable.physics.tension import (
    AbstractTensionLaw,
    Linear,
    Polynomial,
    Rigid,
    Table,
    Tanh,
    TensionOnly,
)
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import held_force
from lumpedcable.scene.materials import InextensibleMaterial

__all__ = ["LAWS", "STANDARD_GRAVITY", "law_of", "relaxation_of", "rest_stiffness", "rod_law"]

STANDARD_GRAVITY = 9.80665  # m/s2
# m; rods are first looked for with a strain of their tension over this and their weight per metre
REST_STIFFNESS = 1e7
REST_SHARE = 1e7  # and of its tension over this and the pretensions and points that it may carry


LAWS = {
    "linear": lambda m: Linear(number(m.EA)),
    "tanh": lambda m: Tanh(*(number(getattr(m, f"p{k}")) for k in range(1, 6))),
    "polynomial": lambda m: Polynomial(vector(m.coefficients)),
    "table": lambda m: Table(vector(m.strain), vector(m.tension)),
}


def law_of(material) -> AbstractTensionLaw:
    """The law of a material of the scene, cut at zero where it is tension-only."""
    law = LAWS[material.law](material)
    return TensionOnly(law, number(material.max_strain)) if material.tension_only else law


def relaxation_of(material) -> Relaxation | None:
    """The branches of a material of the scene, in the order of their names; None where it has none."""
    branches = [material.relaxation[name] for name in sorted(material.relaxation)]
    if not branches:
        return None
    return Relaxation(vector(b.EA for b in branches), vector(b.time for b in branches))


def rod_law(scene: Scene, name: str) -> AbstractTensionLaw:
    """The law by which an inextensible line finds its shape at rest: that of its EA, or of rods."""
    material = scene.materials[scene.lines[name].material]
    assert isinstance(material, InextensibleMaterial)
    if material.EA is not None:
        return Linear(number(material.EA))
    return Rigid(jnp.zeros(()), rest_stiffness(scene, name))


def rest_stiffness(scene: Scene, name: str) -> Float[Array, ""]:
    """EA (N) with which an inextensible line at rest is first found, from what it may carry."""
    stiff = REST_STIFFNESS * STANDARD_GRAVITY * number(scene.lines[name].mass)
    for line in scene.lines.values():
        for end in (line.start, line.end):
            if (held := held_force(end)) is not None:
                stiff = stiff + REST_SHARE * number(held.pretension)
    for body in scene.bodies.values():
        if isinstance(body, Body) and not body.rigid:
            stiff = stiff + REST_SHARE * STANDARD_GRAVITY * number(body.mass)
    return stiff
