"""Scenes without a duration: at rest, but those of records move all the same, while their data last."""

import jax
import numpy as np
import pytest
from engine_runs import study_of
from fit_files import fit_of

import lumpedcable as lc
from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.residual import predict
from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import sensitivity_of
from lumpedcable.status import Status

HUNG = """\
gravity = "9.81 m/s2"

[materials.wire]
law = "linear"
EA = "1 MN"
damping = "20 kN s"

[lines.rope]
material = "wire"
length = "10 m"
segments = 4
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = "ship.bow"

[bodies.ship]
position = ["10.2 m", 0, 0]
points = { bow = [0, 0, 0] }
motion = { surge = { amplitude = "10 cm", period = "1 s" } }
"""
OUTPUT = "\n[output]\n"
LASTS = OUTPUT + 'duration = "90 ms"\nevery = "10 ms"\n'
FIT = """
scene = "scene.toml"

[free]
"materials.wire.EA" = { start = "1 MN" }

[experiments.pull]
file = "pull.csv"
time = { column = "t", unit = "ms" }
observe = [{ quantity = "tension", at = "rope.end", column = "T", noise = "1 N" }]
"""


def predicted(folder, text, stepping=""):
    folder.mkdir()
    (folder / "pull.csv").write_text("t,T\n" + "".join(f"{t},1\n" for t in (30, 60, 90)))
    spec, arrays = arrays_of(fit_of(folder, FIT, text + stepping).problem)
    found = jax.jit(predict, static_argnums=0)(spec, arrays, np.array([1e6]))
    assert Status(int(found.status[0][0])) == Status.OK
    return np.asarray(found.groups[0])[0, 0]


@pytest.mark.slow
def test_a_ship_moves_along_with_its_data(tmp_path):
    with_it, without = (
        predicted(tmp_path / "a", HUNG + LASTS),
        predicted(tmp_path / "b", HUNG + OUTPUT),
    )
    np.testing.assert_array_equal(without, with_it)
    # sin(2 pi t / P) rises by 0.35 from 30 to 90 ms: 3.5 cm over 10 m of EA
    assert without[-1] - without[0] > 0.9 * 0.0035 * 1e6


@pytest.mark.slow
def test_a_step_that_is_asked_for_is_taken(tmp_path):
    step = '\n[solver]\nstep = "100 us"\n'
    with_it = predicted(tmp_path / "a", HUNG + LASTS, step)
    np.testing.assert_array_equal(predicted(tmp_path / "b", HUNG + OUTPUT, step), with_it)


# ends at rest, so that nothing moves the wire: T = EA (d / L - 1)
TAUT = HUNG.replace('gravity = "9.81 m/s2"\n', "").partition('end = "ship')[0]
TAUT += f"end = {{ fixed = [10.2, 0, 0] }}\n{OUTPUT}"
EXACT = {"materials.wire.EA": 0.02, "lines.rope.length": -1e6 * 10.2 / 100.0}  # dT/dEA, dT/dL


@pytest.mark.slow
def test_a_response_of_a_scene_at_rest(tmp_path):
    path = tmp_path / "taut.toml"
    path.write_text(TAUT)
    found = lc.response(path, list(EXACT), "max tension at rope.end", spare=0.5)
    with_slopes = jax.value_and_grad(found)
    value, slopes = with_slopes(found.values)
    assert float(value) == pytest.approx(20e3, rel=1e-9)
    np.testing.assert_allclose(slopes, list(EXACT.values()), rtol=1e-9)
    assert with_slopes([1e6, 10.2 / 1.49])[0] == pytest.approx(490e3, rel=1e-9)
    value, slopes = with_slopes([1e6, 10.2 / 1.51])  # beyond max_strain, which is 0.5
    assert np.all(np.isnan([value, *slopes]))
    np.testing.assert_allclose(found.history(found.values), [20e3], rtol=1e-9)


@pytest.mark.slow
def test_a_sensitivity_of_a_scene_at_rest_by_one_way_back(tmp_path):
    study = study_of(tmp_path, TAUT)
    found = sensitivity_of(study, read_scalar("max tension at rope.end", study.scene), reverse=True)
    slopes = dict(zip(found.keys, found.slopes, strict=True))
    assert {key: slopes[key] for key in EXACT} == pytest.approx(EXACT, rel=1e-9)
