"""Lines that lie slack on a bed with a slope: laid out along it, not folded into struts."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, run_text, scene_of
from scipy.integrate import quad
from scipy.optimize import fsolve

from lumpedcable.status import Status

EA, WEIGHT = 10e6, 98.1
SCENE = """
gravity = 9.81
[seabed]
height = 0
stiffness = "{stiffness}"
{profile}
[materials.chain]
law = "linear"
EA = "10 MN"
[lines.rope]
material = "chain"
length = {length}
segments = {segments}
mass = 10
start = {{ fixed = [0, 0, 0] }}
end = {{ fixed = [100, 0, 10] }}
[output]
"""


def exact(length: float, slope: float) -> tuple[float, float]:
    """Tensions (N) at the ends of a line from (0, 0) down a smooth slope and up to (100, 10) m.

    On the slope it loses w sin p per metre; from where it leaves the slope, along it, it is an elastic
    catenary (H. M. Irvine, Cable Structures, 1981, section 1.3, from its differential equations).
    """
    p = np.arctan(slope)

    def reached(unknown):
        touch, lying = (
            unknown  # tension (N) where it leaves the bed, and unstretched length (m) until there
        )
        mean = touch + 0.5 * WEIGHT * np.sin(p) * lying
        way = lying * (1.0 + mean / EA)
        H, V = touch * np.cos(p), -touch * np.sin(p)
        hangs = length - lying

        def step(s, part):
            T = np.hypot(H, V + WEIGHT * s)
            return part(s) * (1.0 / T + 1.0 / EA)

        x = quad(step, 0.0, hangs, args=(lambda s: H,))[0]
        z = quad(step, 0.0, hangs, args=(lambda s: V + WEIGHT * s,))[0]
        return way * np.cos(p) + x - 100.0, -way * np.sin(p) + z - 10.0

    touch, lying = np.asarray(fsolve(reached, (500.0, 0.7 * length), xtol=1e-12), float)
    start = touch + WEIGHT * np.sin(p) * lying
    return start, np.hypot(touch * np.cos(p), WEIGHT * (length - lying) - touch * np.sin(p))


def tensions_at_rest(folder, text):
    """Tensions (N) of the segments."""
    found, _ = equilibrium_of(scene_of(folder, text))
    assert found.converged
    line = found.model.lines["rope"]
    return np.asarray(line.law.tension(line.reference_strain))


@pytest.mark.parametrize(
    ("length", "slope", "segments", "stiffness"),
    [
        pytest.param(115, 0.1, 100, "100 MPa", marks=pytest.mark.slow),
        pytest.param(115, 0.1, 400, "1 MPa", marks=pytest.mark.slow),
        pytest.param(108, 0.05, 100, "1 MPa", marks=pytest.mark.slow),
        (113, 0.05, 100, "1 MPa"),
    ],
)
@pytest.mark.slow
def test_a_slack_line_lies_along_a_slope(tmp_path, length, slope, segments, stiffness):
    profile = f"profile = {{ x = [0, 100], depth = [0, {100 * slope}] }}"
    text = SCENE.format(length=length, segments=segments, stiffness=stiffness, profile=profile)
    tension = tensions_at_rest(tmp_path, text)
    assert np.min(tension) > 0.0
    # chains of lumps: half a segment's weight at the end, and where a segment is half on the bed
    start, end = exact(length, slope)
    coarse = WEIGHT * length / segments
    assert tension[0] == pytest.approx(start, abs=0.5 * coarse)
    assert tension[-1] == pytest.approx(end, abs=coarse)


@pytest.mark.slow
def test_a_strut_on_a_flat_bed_is_no_state_of_rest(tmp_path):
    # 115 m for 110 m of way: nothing pulls at what lies, and a law that pushes folds it
    text = SCENE.format(length=115, segments=50, stiffness="1 MPa", profile="")
    (outcome,) = run_text(tmp_path, text).outcomes
    assert outcome.status is Status.STATICS_NOT_CONVERGED
    assert "tension_only" in outcome.message
    cut = text.replace('EA = "10 MN"', 'EA = "10 MN"\ntension_only = true')
    assert np.min(tensions_at_rest(tmp_path, cut)) >= 0.0
