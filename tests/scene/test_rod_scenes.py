"""Inextensible lines in the scene language: what they ask of the solver."""

from pathlib import Path

import pytest

from lumpedcable.scene import SceneError, load_study

RESTRAINT = Path(__file__).parents[2] / "configs" / "restraint.toml"


def test_single_precision_is_refused():
    # a length held to dt squared: single precision's 4e-6 m at 40 m over (4 ms)^2 are 0.2 m/s2 anywhere
    with pytest.raises(SceneError) as caught:
        load_study(RESTRAINT, ["solver.dtype=float32"])
    told = {(fault.key, fault.message) for fault in caught.value.faults}
    words = 'expected "float64" where lines are inextensible, found "float32"'
    assert told == {("solver.dtype", words)}


BARGE = """\
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "wire"
length = "60 m"
segments = 6
mass = "5 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, 0] }
end = "barge.bow"
[bodies.barge]
mass = "2562 t"
size = ["50 m", "10 m", "5 m"]
position = ["80 m", 0, "-2 m"]
points = { bow = ["-25 m", 0, "2.5 m"] }
free = ["z"]
hull = {}
[output]
"""


def test_a_hull_that_its_box_cannot_carry_is_refused(tmp_path):
    # the box under water to its deck displaces 1025 kg/m3 * 2500 m3 = 2562.5 t
    scene = tmp_path / "scene.toml"
    scene.write_text(BARGE)
    load_study(scene)
    with pytest.raises(SceneError) as caught:
        load_study(scene, ["barge.mass=2563 t"])
    (fault,) = caught.value.faults
    assert fault.key == "bodies.barge.mass"
    assert "(2562.5 t)" in fault.message or "(2.5625e+06 kg)" in fault.message
