"""A shape at rest is judged by the forces of that shape, not by those of the one it was found from."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import scene_of

from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve import start
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.statics import force_scale, make_net, rounding_force, static_residual
from lumpedcable.solve.targets import rest_of

MOORING = """
gravity = 9.81

[water]
density = 1025

[seabed]
height = 0
stiffness = "1 MPa"
profile = { x = [0, 400], depth = [100, 80] }

[materials.chain]
law = "linear"
EA = "400 MN"
tension_only = true

[bodies.clump]
mass = "3 t"
volume = 0.38

[lines.chain]
material = "chain"
length = 200
segments = 120
mass = 120
diameter = 0.1
start = { fixed = [0, 0, -100] }
end = "clump"

[lines.wire]
material = "chain"
length = 150
segments = 90
mass = 20
diameter = 0.06
start = "clump"
end = { fixed = [319, 0, 0] }

[statics]
max_iterations = 400

[output]
"""


def found_of(scene):
    layout, coordinates = make_layout(scene), coordinates_of([scene])
    run = jax.jit(lambda n: rest_of(scene.with_numbers(n), layout, coordinates))
    own = {key: jnp.asarray(value) for key, value in scene.numbers().items()}
    return lambda changes: run(own | {key: jnp.asarray(x) for key, x in changes.items()})


@pytest.mark.slow
def test_a_first_shape_that_is_stretched_beyond_all_bounds_excuses_nothing(tmp_path, monkeypatch):
    # the clump begins 40 m under the bed then, which throws it out
    monkeypatch.setattr(start, "_hung_over_bed", lambda scene, layout, model, joints, given: joints)
    found = found_of(scene_of(tmp_path, MOORING))({})
    model = found.model
    assert found.converged
    net = make_net(model)
    left = np.abs(static_residual(model, jnp.zeros((net.size, 2)), net)).max()
    scale = float(force_scale(model))
    # nothing in it pulls with more than the chain weighs
    assert scale < 2.5e5
    assert left <= 1e-10 * scale + float(rounding_force(model))
    assert found.imbalance < 1e-8


@pytest.mark.slow
def test_moorings_through_a_clump_are_found_at_once_on_any_mesh(tmp_path):
    finer = MOORING.replace("segments = 120", "segments = 200").replace("= 90", "= 150")
    coarser = MOORING.replace("segments = 120", "segments = 60").replace("= 90", "= 40")
    at = [found_of(scene_of(tmp_path, text)) for text in (finer, coarser)]
    for x in (316.0, 319.0, 321.5, 324.0):
        both = [found({"lines.wire.end.fixed.0": x}) for found in at]
        assert all(found.converged for found in both)
        assert all(found.iterations < 50 for found in both)
        one, other = (float(tension_at(found.model.lines["chain"], 0)) for found in both)
        assert one == pytest.approx(other, rel=5e-3)
