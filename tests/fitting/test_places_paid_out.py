"""Places on a line that a drum pays out are where they are at the moment, as measures have them."""

import h5py
import jax
import numpy as np
import pytest
from engine_runs import line_text, run_text

import lumpedcable as lc

DRUM = "{ drum = { at = [0, 0, 0], schedule = { time = [0, 0.5, 3], speed = [0, 1, 1] } } }"
PLACE = 5.0  # m
LOWERED = f"""
gravity = 9.81
[materials.wire]
law = "linear"
EA = 1e7
damping = 2e4
[bodies.load]
mass = 1000
[output]
duration = 2
every = 0.1
[measures.position]
position = "wire@{PLACE} m"
component = "z"
extreme = "least"
[measures.velocity]
velocity = "wire@{PLACE} m"
component = "z"
[measures.displacement]
displacement = "wire@{PLACE} m"
component = "z"
[measures.tension]
tension = "wire@{PLACE} m"
"""
LOWERED += line_text("wire", "wire", 10, 8, 1, DRUM, '"load"')


@pytest.mark.parametrize(
    "quantity",
    [
        "position",
        *(pytest.param(q, marks=pytest.mark.slow) for q in ("velocity", "displacement", "tension")),
    ],
)
def test_they_are_as_a_measure_has_them(tmp_path, quantity):
    run_text(tmp_path, LOWERED)
    with h5py.File(next(tmp_path.glob("*.h5"))) as file:
        told = np.asarray(file["measures"][quantity][0])
    component = "" if quantity == "tension" else " in z"
    of = f"last {quantity} at wire@{PLACE} m{component}"
    response = lc.response(tmp_path / "scene.toml", by=["load.mass", "wire.length"], of=of)
    history = np.asarray(response.history(response.values))
    np.testing.assert_allclose(history, told, rtol=1e-7, atol=1e-9 * np.abs(told).max())


@pytest.mark.slow
def test_a_place_hangs_by_what_is_above_it(tmp_path):
    """However much has been paid out, and however long the line was before."""
    (tmp_path / "scene.toml").write_text(LOWERED)
    of = f"last position at wire@{PLACE} m in z"
    response = lc.response(tmp_path / "scene.toml", by=["wire.length"], of=of)
    stretch = 9.81 * 1009.0 / 1e7  # by the load and the mean of the wire beyond
    assert response(response.values) == pytest.approx(-PLACE * (1.0 + stretch), abs=1e-3)
    assert abs(jax.grad(response)(response.values)[0]) < 1e-2
