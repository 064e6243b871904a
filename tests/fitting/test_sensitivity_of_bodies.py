"""What the travel of a body depends on, against a mass on a spring."""

import numpy as np
import pytest
from engine_runs import study_of

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import Sensitivity, sensitivity_of
from lumpedcable.status import Status

EA, LENGTH, WIRE, MASS, SPEED = 5e3, 2.0, 0.5, 40.0, 1.5  # N, m, kg/m, kg, m/s
MOVED = MASS + 0.5 * WIRE * LENGTH  # the half of the wire that moves with the body
QUARTER = float(0.5 * np.pi * np.sqrt(MOVED * LENGTH / EA))  # s, until it turns back
SLIDER = f"""
[materials.spring]
law = "linear"
EA = {EA}
[lines.spring]
material = "spring"
length = {LENGTH}
segments = 1
mass = {WIRE}
start = {{ fixed = [0, 0, 0] }}
end = "slider"
[bodies.slider]
mass = {MASS}
size = [1, 1, 1]
position = [{LENGTH}, 0, 0]
velocity = [{SPEED}, 0, 0]
free = ["x"]
[solver]
waves = "plain"
step = {QUARTER / 100!r}
[output]
duration = {QUARTER!r}
every = {QUARTER / 10!r}
"""


@pytest.mark.slow
def test_shares_of_the_travel_of_a_mass_on_a_spring(tmp_path):
    # x = v sqrt(M L / EA) sin(t / sqrt(M L / EA)), at its largest at the last output time
    study = study_of(tmp_path, SLIDER)
    found = sensitivity_of(study, read_scalar("max displacement at slider", study.scene))
    assert found.value == pytest.approx(SPEED * np.sqrt(MOVED * LENGTH / EA), rel=1e-4)
    assert found.scalar.unit == "m"
    share = dict(zip(found.keys, found.shares, strict=True))
    wire = 0.5 * WIRE * LENGTH / MOVED
    wanted = {
        "bodies.slider.velocity.0": 1.0, "materials.spring.EA": -0.5,
        "bodies.slider.mass": 0.5 * MASS / MOVED, "lines.spring.mass": 0.5 * wire,
    }  # fmt: skip
    for key, value in wanted.items():
        assert share[key] == pytest.approx(value, abs=1e-3), key
    # neither the unit of mass nor the size of the speed matters, to rounding
    massive = [k for k in share if k.endswith((".mass", ".EA"))]
    assert sum(share[k] for k in massive) == pytest.approx(0.0, abs=1e-9)
    assert share["bodies.slider.velocity.0"] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("of", "said"),
    [("max tension at sledge", 'a place on a line for a tension, found the body "sledge"'),
     ("max velocity at slidr", r'or a rigid body or a trolley \(slider, sledge\), found "slidr"')],
)  # fmt: skip
def test_a_scalar_that_a_body_does_not_have(tmp_path, of, said):
    alone = "[bodies.sledge]\nmass = 1\nsize = [1, 1, 1]\nposition = [9, 0, 0]\nfree = ['x']\n"
    study = study_of(tmp_path, SLIDER + alone)
    with pytest.raises(ValueError, match=said):
        sensitivity_of(study, read_scalar(of, study.scene))


def test_a_result_that_rounding_decides_is_said_to_be_one(tmp_path):
    study = study_of(tmp_path, SLIDER)
    scalar = read_scalar("max displacement at slider", study.scene)
    shares = np.array([2e9, -0.5, np.nan])
    found = Sensitivity(
        scalar,
        1.0,
        Status.OK,
        ("a", "b", "c"),
        ("a", "b", "c"),
        ("", "", ""),
        np.ones(3),
        shares,
        shares,
    )
    assert ["say nothing" in remark for remark in found.remarks] == [True, False]
    assert found.remarks[1] == "By 1 of the numbers it has no derivative here."


HIGHLINE = """
gravity = 10
[materials.steel]
law = "linear"
EA = "57 MN"
[bodies.cargo]
mass = 2000
height = 0
on = { line = "highline", place = "30 m" }
[lines.highline]
model = "ideal"
material = "steel"
length = "60 m"
segments = 20
mass = "3 kg/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = [60, 0, 0], tension = 80e3 } }
[solver]
method = "rk4"
step = "1 ms"
[output]
duration = "2.5 s"
every = "2 ms"
"""


def test_how_deep_cargo_falls_on_a_trolley(tmp_path):
    study = study_of(tmp_path, HIGHLINE)
    found = sensitivity_of(study, read_scalar("max displacement at cargo", study.scene))
    # T (2 sqrt(h^2 + a^2) - 2 a) = m g h: h = 2 a k / (1 - k^2), k = m g / 2 T
    k = 2000 * 10 / 2 / 80e3
    assert found.value == pytest.approx(2 * 30 * k / (1 - k**2), rel=1e-6)
    share = dict(zip(found.keys, found.shares, strict=True))
    # at the output that is up to 1 ms away from the turn, where it still moves
    assert share["bodies.cargo.mass"] == pytest.approx(1 + 2 * k**2 / (1 - k**2), rel=1e-3)
    winch = share["lines.highline.end.winch.tension"]
    assert winch == pytest.approx(-share["bodies.cargo.mass"], rel=1e-9)
