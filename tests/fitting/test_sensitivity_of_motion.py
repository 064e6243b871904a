"""Derivatives of measures of motion: of a line of Hooke's law all that moves goes with the tension."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import HOOKE, study_of

from lumpedcable.fitting.residual import run_group
from lumpedcable.fitting.scalar import read_scalar, usual_scalar
from lumpedcable.fitting.sensitivity import setting_of
from lumpedcable.study.compiled import RUN_ONCE

PRETENSION, EA, TENSION = "lines.rope.end.held.pretension", 1e6, 50e3
TEXT = (
    HOOKE.replace("segments = 50", "segments = 10")
    + """
[measures]
mid = { position = "rope@33 m", component = "x" }
gone = { displacement = "rope.end" }
back = { velocity = "rope.end", component = "x", extreme = "least" }
[solver]
waves = "plain"
"""
)


@pytest.mark.parametrize(
    ("what", "unstretched"),
    [
        ("last mid", 33.0),
        pytest.param("max gone", 0.0, marks=pytest.mark.slow),
        pytest.param("min back", 0.0, marks=pytest.mark.slow),
    ],
)
def test_what_moves_goes_with_the_tension(tmp_path, what, unstretched):
    scene = study_of(tmp_path, TEXT).runs[0]
    spec, arrays = setting_of(scene, read_scalar(what, scene), [PRETENSION], False)

    def history(tension):
        return run_group(spec, arrays, tension)[0][0, 0]

    both = jax.jit(lambda x: (history(x), jax.jacfwd(history)(x)), compiler_options=RUN_ONCE)
    found, slope = map(np.asarray, both(jnp.asarray([TENSION])))
    assert np.ptp(found) > 1.0
    owed = (found - unstretched) / TENSION
    np.testing.assert_allclose(slope[1:, 0], owed[1:], rtol=1e-9, atol=1e-12 * np.ptp(owed))
    if what == "last mid":
        assert slope[0, 0] == pytest.approx(33.0 / EA, rel=1e-9)


def test_the_least_is_what_is_asked_for(tmp_path):
    still = HOOKE.replace('[events.break]\nbreaks = "rope.end"\ntime = 0\n', "")
    low = 'low = { position = "rope.end", component = "z", extreme = "least" }'
    scene = study_of(tmp_path, f"{still}\n[measures]\n{low}\n").scene
    assert str(usual_scalar(scene)) == "min low"
