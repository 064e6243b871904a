"""What a measure of a scene depends on, where it begins at exactly nothing."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import study_of

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes
from lumpedcable.model.places import PlaceMeasured, Seen

SPEED = 0.02  # m/s
PULLED = f"""
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "wire"
length = 20
segments = 2
mass = 1
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = [20, 0, 0], velocity = [{SPEED}, 0, 0], ramp = 0.01 }} }}
[measures.v]
speed = "rope@15 m"
[output]
duration = 0.02
every = 0.01
"""


@pytest.mark.slow
def test_a_speed_that_begins_at_zero_has_derivatives(tmp_path):
    study = study_of(tmp_path, PULLED)
    scalar, key = read_scalar("max v", study.scene), "lines.rope.end.motion.velocity.0"
    value, status, slopes = scalar_slopes(study, scalar, (key,), np.array([SPEED]))
    assert status.name == "OK"
    # a straight line of Hooke's law answers in proportion
    assert slopes == pytest.approx([value / SPEED], rel=1e-9)


def test_the_speed_of_an_end_has_derivatives_at_rest_too():
    end = PlaceMeasured("speed", ("rope",), -1, None)

    def speed(velocity):
        return end.value(None, 0.0, Seen({}, {"rope": velocity}, {}, {}))

    moving = jnp.array([[0.0, 3.0], [0.0, 4.0]])
    np.testing.assert_allclose(jax.grad(speed)(moving)[:, 1], [0.6, 0.8], rtol=1e-12)
    assert np.all(jax.grad(speed)(jnp.zeros((2, 2))) == 0.0)


# cargo on an ideal cable along x without weight: all lies on one line, and heights are across it
ALONG = """
[materials.steel]
law = "linear"
EA = "5 MN"
[bodies.cargo]
mass = "200 kg"
on = { line = "highline", place = "10 m" }
[lines.highline]
model = "ideal"
material = "steel"
length = "30 m"
segments = 2
mass = 1
start = { fixed = [0, 0, 10] }
end = { winch = { at = [30, 0, 10], tension = "20 kN" } }
[measures.h]
height = "cargo"
[solver]
method = "tsit5"
[output]
duration = 0.02
every = 0.01
"""


@pytest.mark.slow
def test_a_height_follows_what_leads_out_of_the_line_of_its_scene(tmp_path):
    study = study_of(tmp_path, ALONG)
    keys = ("lines.highline.start.fixed.2", "lines.highline.end.winch.at.2")
    value, _, slopes = scalar_slopes(
        study, read_scalar("last h", study.scene), keys, np.array([10.0, 10.0])
    )
    assert value == 10.0
    # at a third of the chord
    assert slopes == pytest.approx([2.0 / 3.0, 1.0 / 3.0], rel=1e-9)
