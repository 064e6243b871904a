"""The scenes of configs/surface do what their first lines say."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_scenes

from lumpedcable.exact import release_wave
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.known_waves import curve_of

SCENES = Path(__file__).parents[2] / "configs" / "surface"


@pytest.mark.slow
def test_a_line_that_parts_in_the_air_comes_as_if_there_were_no_water(tmp_path):
    study = load_study(SCENES / "deck-line.toml", ["rope.segments=50"])
    ran = run_scenes(tmp_path, study)
    assert ran.statuses == ["OK"] * 5
    speed = np.linalg.norm(ran["velocity"][:, -1, -1], axis=1)
    exact = release_wave(curve_of(study.runs[0], "rope"), 2.238, tension0=180e3).end_speed
    # the water has not been heard of at the end of what is 20 m and more in the air
    np.testing.assert_allclose(speed[:3], exact, rtol=0.01)
    assert speed[4] < 0.4 * exact
    gone = np.linalg.norm(ran["position"][:, -1, -1] - ran["position"][:, 0, -1], axis=1)
    assert gone[4] == pytest.approx(0.5 * gone[0], rel=0.05)


@pytest.mark.slow
def test_a_buoy_follows_its_waves(tmp_path):
    ran = run_scenes(tmp_path, load_study(SCENES / "buoy.toml", ["ahead.segments=10"]))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
    with open_result(tmp_path / "result.h5") as result:
        found = {name: history[0] for name, (history, _) in result.measures().items()}
    late = ran.time >= 10.0
    heave, waves = found["heave"][late], found["waves"][late]
    assert np.corrcoef(heave, waves)[0, 1] > 0.85
    assert np.std(heave) == pytest.approx(np.std(waves), rel=0.1)


@pytest.mark.slow
def test_a_barge_that_loses_a_chain_begins_with_its_pretension(tmp_path):
    ran = run_scenes(tmp_path, load_study(SCENES / "moored-barge.toml"))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
    for name in ("port_bow", "star_bow"):
        assert ran[f"{name}.end_tension"][0, 0] == pytest.approx(200e3, rel=1e-6)
    # the wind pushes with 60 kN, and what waves do comes later: all horizontal forces balance
    ends = {name: ran[f"{name}.position"][0, 0] for name in ran.lines}
    level = 0.0
    for name, nodes in ends.items():
        way = nodes[-2] - nodes[-1]
        level += ran[f"{name}.tension"][0, 0, -1] * way[0] / np.linalg.norm(way)
    assert level == pytest.approx(60e3, rel=1e-6)
    place = ran.bodies["barge"]["position"][0]
    before, last = ran.time < 15.0, np.linalg.norm(place[-1, :2] - place[0, :2])
    assert np.linalg.norm(place[before, :2] - place[0, :2], axis=1).max() < 1.5
    assert place[-1, 1] < -15.0  # to the side of the chain that is left
    assert last == pytest.approx(25.0, abs=0.5)
    peak = ran["star_bow.end_tension"][0].max()
    assert 300e3 < peak < 315e3


RAISED = """
gravity = 9.81
water = {{ density = 1025, surface = {z}, current = {{ profile = "power", velocity = [1, 0, 0], \
exponent = 0.2, depth = 10 }} }}
sea = {{ height = 1, period = 5, components = 3, depth = 20, flow = {{}} }}
[materials.rope]
law = "linear"
EA = 1e5
[bodies.ball]
mass = 60
volume = 0.1
position = [6, 0, {z}]
free = ["x", "y", "z"]
[lines.rope]
material = "rope"
length = 10
segments = 4
mass = 1
diameter = 0.03
drag = {{ normal = 1.2, tangential = 0.01 }}
start = {{ fixed = [0, 0, {z} - 8] }}
end = "ball"
[measures.waves]
elevation = [6, 0]
[output]
duration = 2
every = 0.5
"""


@pytest.mark.slow
def test_what_does_not_tell_its_surface_has_that_of_the_water(tmp_path):
    # the whole scene 5 m higher: current, waves and what floats on them
    found = []
    for z in (0.0, 5.0):
        text = RAISED.replace("{z} - 8", "{low}").format(z=z, low=z - 8)
        folder = tmp_path / str(z)
        folder.mkdir()
        (folder / "scene.toml").write_text(text)
        ran = run_scenes(folder, load_study(folder / "scene.toml"))
        assert ran.statuses == ["OK"]
        with open_result(folder / "result.h5") as result:
            place = result.body("ball", "position")[0] - [0.0, 0.0, z]
            found.append((place, ran["tension"], result.measures()["waves"][0]))
    assert np.ptp(found[0][0][:, 2]) > 0.1  # it goes with the waves
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-7, atol=1e-7)
