"""Tension laws by the name that the scene language gives them: the one place where they meet."""

import jax.numpy as jnp

from lumpedcable.physics.tension import (
    AbstractTensionLaw,
    Linear,
    Polynomial,
    Table,
    Tanh,
    TensionOnly,
)

__all__ = ["LAWS", "law_of"]


def _number(value):
    return jnp.asarray(value, float)


LAWS = {
    "linear": lambda m: Linear(_number(m.EA)),
    "tanh": lambda m: Tanh(*(_number(getattr(m, f"p{k}")) for k in range(1, 6))),
    "polynomial": lambda m: Polynomial(jnp.stack([_number(c) for c in m.coefficients])),
    "table": lambda m: Table(
        jnp.stack([_number(e) for e in m.strain]), jnp.stack([_number(t) for t in m.tension])
    ),
}


def law_of(material) -> AbstractTensionLaw:
    """The law of a material of the scene, cut at zero where it is tension-only."""
    law = LAWS[material.law](material)
    return TensionOnly(law, _number(material.max_strain)) if material.tension_only else law
