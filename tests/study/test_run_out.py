"""A line that breaks runs out through the trolley on it: the run says when, and is right until then."""

from types import SimpleNamespace

import numpy as np
import pytest
from engine_runs import run_text

from lumpedcable.model.bodies import body_key
from lumpedcable.solve.run_out import run_out
from lumpedcable.status import Status

EA, MASS, PULL, AWAY = 5e6, 3.0, 60e3, 10.0
HIGHLINE = f"""
gravity = "9.81 m/s2"
[materials.steel]
law = "linear"
EA = "5 MN"
tension_only = true
damping = "5 kN s"
[bodies.cargo]
mass = "100 kg"
on = {{ line = "highline", place = "{AWAY} m" }}
[lines.highline]
material = "steel"
length = "60 m"
segments = 60
mass = "3 kg/m"
start = {{ fixed = [0, 0, "20 m"] }}
end = {{ winch = {{ at = ["60.5 m", 0, "20 m"], tension = "60 kN", speed = "2 m/s" }} }}
"""
PARTED = """
[events.part]
breaks = "highline.start"
start = "0.1 s"
time = "5 ms"
[output]
duration = "1.2 s"
every = "10 ms"
"""
ROLLS = """
[output]
duration = "8 s"
every = "50 ms"
keep = "histories"
"""


def ended(moved):
    """Whether a line of four segments of 1 m has run out under a trolley, (2, 1), moved from (0, 0)."""
    nodes = np.array([np.arange(5.0), np.zeros(5)])
    coupled = SimpleNamespace(line="rope", body="cargo")
    model = SimpleNamespace(
        couplings=[coupled], bodies={"cargo": SimpleNamespace(reference=np.zeros(2))}
    )
    found = {"rope": SimpleNamespace(line=SimpleNamespace(shape=SimpleNamespace(position=nodes)))}
    return bool(run_out(model, found, {body_key("cargo"): moved[:, 0]})["cargo"])


def nearest(ran):
    """Number of the node nearest to the trolley, (outputs,)."""
    nodes, place = ran.lines["highline"]["position"][0], ran.bodies["cargo"]["position"][0]
    return np.argmin(np.linalg.norm(nodes - place[:, None], axis=-1), axis=1)


@pytest.mark.slow
def test_a_highline_that_parts_runs_out_through_its_trolley(tmp_path):
    ran = run_text(tmp_path, HIGHLINE + PARTED)
    (outcome,) = ran.outcomes
    assert outcome.status is Status.LINE_RUN_OUT
    before = ran.time < outcome.status_time
    assert np.all(nearest(ran)[before] > 0)
    assert nearest(ran)[before.sum()] == 0
    # let go it runs with T/(m c), c^2 = EA/m, till half a segment is left; its weight and a winch that
    # still pulls only make it faster, the winch no more than twice as fast
    longest = (AWAY - 0.5) / (PULL / np.sqrt(EA * MASS))
    assert 0.5 * longest < outcome.status_time - 0.105 < longest
    assert abs(outcome.energy_closure) < 1e-3
    assert "runs out through the trolley" in outcome.message


def test_what_is_undefined_has_not_run_out():
    """A place that is no number is nearest to nothing: the run tells what went wrong before."""
    places = {"near": [[0.4, 0.0]], "between": [[1.6, 0.0]], "undefined": [[np.nan, 0.0]]}
    shown = {name: ended(np.array(place).T) for name, place in places.items()}
    assert shown == {"near": True, "between": False, "undefined": False}


@pytest.mark.slow
def test_a_trolley_that_rolls_to_a_post_says_so(tmp_path):
    """Down 15 m over 60 m it comes there within seconds; before, it is borne as ever."""
    ran = run_text(tmp_path, HIGHLINE.replace('0, "20 m"], tension', '0, "5 m"], tension') + ROLLS)
    (outcome,) = ran.outcomes
    assert outcome.status is Status.LINE_RUN_OUT
    place = ran.bodies["cargo"]["position"][0, ran.time < outcome.status_time]
    assert 58.0 < place[-1, 0] < 60.5
