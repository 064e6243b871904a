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


@pytest.fixture
def first_case(tmp_path):
    """The file's scene without its cases."""
    path, text = tmp_path / "first.toml", RESTRAINT.read_text()
    path.write_text(text[: text.index("[[sweep.cases]]")])
    return path


def faults_of(path, *overrides):
    with pytest.raises(SceneError) as caught:
        load_study(path, overrides)
    return {fault.key: fault.message for fault in caught.value.faults}


def test_a_stop_of_a_body_that_does_not_move_is_refused(first_case):
    words = 'expected a body that starts with a velocity, found "ship"'
    assert words in faults_of(first_case, "bodies.ship.velocity.0=0 m/s")["output.stop"]
    # also in one run of a sweep alone, which is told
    text = first_case.read_text() + '[sweep]\n"bodies.ship.velocity.0" = [3, 0, 4]\n'
    first_case.write_text(text)
    told = faults_of(first_case)["output.stop"]
    assert words in told
    assert "(in the run with bodies.ship.velocity.0 = 0 m/s)" in told


@pytest.mark.parametrize(
    ("change", "heights"),
    [
        ("seabed.height=-20 m", ("-20 m", "-6.0312 m", "-18.95 m")),  # hangs over the bed
        ("bodies.anchor.position.2=-5.5 m", ("-6.0312 m", "-6.55 m", "-4.9812 m")),  # buried
    ],
)
def test_a_body_with_friction_that_is_not_on_the_bed_is_refused(first_case, change, heights):
    told = faults_of(first_case, change)["bodies.anchor.position.2"]
    for words in (*heights, "seabed.height"):
        assert words in told


@pytest.mark.parametrize("height", ["-4.85 m", "-5.1 m"])  # of a body 2.1 m high
def test_a_body_with_friction_may_lie_a_little_above_the_bed_or_in_it(first_case, height):
    load_study(first_case, [f"bodies.anchor.position.2={height}"])


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
