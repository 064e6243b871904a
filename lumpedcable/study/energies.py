"""Which energies a study accounts for."""

import jax

from lumpedcable.model.assemble import assemble
from lumpedcable.model.couple import body_works
from lumpedcable.model.energy import WORKS, works_of
from lumpedcable.study.laying import Laid

__all__ = ["energy_terms"]

STORED = {
    "kinetic": "kinetic energy, added mass included",
    "strain": "strain energy",
    "gravitational": "potential energy of weight less buoyancy",
    "bending": "bending energy",
    "seabed": "energy stored in the seabed",
    "winch": "what winches have put into the lines, as if it were stored",
    "contact": "energy stored where trolleys touch their lines",
    "hydrostatic": "energy of hulls that heave, roll or pitch",
    "control": "what holds ships at their places, as if it were stored",
}


def energy_terms(laid: Laid) -> dict[str, str]:
    """Energy datasets of a study: name to long name, stored ones first."""
    # only names and structure are asked for: nothing is computed
    scene, layout = laid.scene, laid.structures[0].layout.whole
    model = jax.eval_shape(lambda: assemble(scene, layout, laid.coordinates))
    stored = {"kinetic", "strain"}
    kinds: set[str] = set()
    for line in model.lines.values():
        stored |= {load.energy_name for load in line.loads}
        kinds |= set(works_of(line, scene.solver.method == "leapfrog"))
    for name, body in model.bodies.items():
        stored |= set(jax.eval_shape(lambda b: b.stored(b.reference), body))
        kinds |= set(body_works(model, name))
    stored |= {coupled.law.energy_name for coupled in model.couplings}
    if any(junction.load is not None for junction in model.junctions):
        stored.add("gravitational")
    terms = {name: text for name, text in STORED.items() if name in stored}
    for kind, (sign, text) in WORKS.items():
        if kind in kinds:
            terms[f"work_{kind}" if sign > 0 else f"lost_{kind}"] = text
    return terms
