"""Tension and speed at places along lines: against exact statics and against the fields."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable import response
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

HANGING = """
title = "A hanging line"
gravity = "9.81 m/s2"

[materials.steel]
law = "linear"
EA = "1 MN"

[lines.line]
material = "steel"
length = "10 m"
segments = 7
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = "free"

[measures.tension]
tension = "line"
place = "3.3 m"

[measures.top]
tension = "line.start"

[output]
duration = "20 ms"
every = "10 ms"
"""
PARTED = """
title = "A line that parts between its ends"

[materials.steel]
law = "linear"
EA = "1 MN"

[lines.line]
material = "steel"
length = "10 m"
segments = 20
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "10 kN", direction = [1, 0, 0] } }

[events.parts]
breaks = "line@4 m"
time = 0

[measures]
near = { tension = "line@1.9 m" }
far = { tension = "line@7.3 m" }
end = { tension = "line.end" }
slow = { speed = "line@1.9 m" }
cut = { speed = "line@4 m" }

[output]
duration = "20 ms"
every = "1 ms"
"""

STREAMING = """
[water]
density = "1000 kg/m3"
current = { velocity = ["5 m/s", 0, 0] }

[materials.soft]
law = "linear"
EA = "1 MN"

[lines.line]
material = "soft"
length = "100 m"
segments = 20
mass = "1 kg/m"
diameter = "50 mm"
drag = { normal = 1.2, tangential = 0.01 }
start = { fixed = [0, 0, 0] }
end = "free"

[measures]
start = { tension = "line.start" }
place = { tension = "line", place = "0 m" }
end = { tension = "line.end" }

[output]
duration = "0.2 s"
every = "0.1 s"
"""


def ran(folder, text, *overrides):
    path, target = folder / "scene.toml", folder / "out.h5"
    path.write_text(text)
    (outcome, *_) = run_study(load_study(path, list(overrides)), target)
    return target, outcome


def test_tension_of_a_hanging_line_at_any_place(tmp_path):
    """T(s) = m g (L - s), linear, so that it is exact between segments and beyond their middles."""
    places = [0.0, 0.1, 1.0, 3.3, 9.9, 10.0]
    target, outcome = ran(tmp_path, HANGING, f"measures.tension.place={places}")
    with open_result(target) as result:
        found, attributes = result.measures()["tension"]
        top, _ = result.measures()["top"]
    exact = 2.0 * 9.81 * (10.0 - np.array(places))
    np.testing.assert_allclose(found, exact[:, None] * np.ones(3), rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(top, 2.0 * 9.81 * 10.0, rtol=1e-9)
    assert attributes["units"] == "N"
    assert outcome.energy_closure == 0.0  # nothing moved: there is nothing to be a share of


def test_a_current_along_a_line_pulls_at_its_ends(tmp_path):
    """T(s) = rho pi d C_t v^2 (L - s) / 2, linear, so that it is exact at any mesh, at the ends too."""
    target, _ = ran(tmp_path, STREAMING)
    with open_result(target) as result:
        found = {name: table for name, (table, _) in result.measures().items()}
        ends = [result.line("line").field(f"{end}_tension") for end in ("start", "end")]
    whole = 0.5 * 1000.0 * np.pi * 0.05 * 0.01 * 5.0**2 * 100.0
    for table in (found["place"], found["start"], ends[0]):
        np.testing.assert_allclose(table, whole, rtol=1e-9)
    for table in (found["end"], ends[1]):  # it is free
        np.testing.assert_allclose(table, 0.0, atol=1e-6 * whole)


@pytest.mark.slow
def test_places_of_a_parted_line_are_what_the_fields_say(tmp_path):
    target, _ = ran(tmp_path, PARTED)
    with open_result(target) as result:
        measured = {name: table[0] for name, (table, _) in result.measures().items()}
        first, second = result.line("line-1"), result.line("line-2")
        middles = {n: p.unstretched_segment() for n, p in (("a", first), ("b", second))}
        tension = {"a": first.tension(0), "b": second.tension(0)}
        velocity = first.velocity(0)[..., 0]  # along x, as all of it
        nodes = first.unstretched_position()
        end = second.field("end_tension")[0]
        cut = np.linalg.norm(second.velocity(0)[:, 0], axis=-1)
    each = range(len(end))
    near = [np.interp(1.9, middles["a"], tension["a"][k]) for k in each]
    far = [np.interp(7.3, middles["b"], tension["b"][k]) for k in each]
    slow = [abs(np.interp(1.9, nodes, velocity[k])) for k in each]
    np.testing.assert_allclose(measured["near"], near, rtol=1e-9)
    np.testing.assert_allclose(measured["far"], far, rtol=1e-9)
    np.testing.assert_allclose(measured["end"], end, rtol=1e-12)
    np.testing.assert_allclose(measured["slow"], slow, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(measured["cut"], cut, rtol=1e-12)  # the part from the cut on
    # the wave has passed: the place beside the fixed end carries nothing of its 10 kN, and both move
    assert measured["slow"].max() > 1.0
    assert near[0] == pytest.approx(10e3, rel=1e-9)


@pytest.mark.slow
def test_summaries_have_the_largest(tmp_path):
    target, _ = ran(tmp_path, PARTED)
    with open_result(target) as result:
        largest = {name: np.nanmax(table) for name, (table, _) in result.measures().items()}
    target, outcome = ran(tmp_path, PARTED, 'output.keep="summaries"')
    assert set(outcome.measures) == set(largest)
    for name, value in largest.items():
        assert outcome.measures[name] == pytest.approx(value, rel=1e-12)
    with open_result(target) as result:
        assert not result.measures()


LATE = """
[measures.late]
tension = "line@1.9 m"
after = "8 ms"
"""


@pytest.mark.slow
def test_a_measure_may_count_from_a_time_on(tmp_path):
    target, outcome = ran(tmp_path, PARTED + LATE)
    with open_result(target) as result:
        time, found = result.time, {k: table[0] for k, (table, _) in result.measures().items()}
        told = result.measures()["late"][1]
    counts = time >= 8e-3
    assert 0 < counts.sum() < time.size
    np.testing.assert_array_equal(found["late"][counts], found["near"][counts])
    assert np.isnan(found["late"][~counts]).all()
    assert outcome.measures["late"] == found["near"][counts].max()
    assert outcome.measures["late"] < outcome.measures["near"]
    assert told["long_name"] == "tension at line@1.9 m, from 8 ms on"
    _, kept = ran(tmp_path, PARTED + LATE, 'output.keep="summaries"')
    assert kept.measures["late"] == pytest.approx(outcome.measures["late"], rel=1e-12)


@pytest.mark.slow
def test_what_counts_from_a_time_on_has_the_derivative_of_its_part(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(PARTED + LATE)
    late = response(scene, ["pretension"], "max late")
    value, slope = jax.value_and_grad(late)(jnp.array([10e3]))
    # what waves of Hooke's law leave is in proportion to the pretension
    assert float(slope[0]) == pytest.approx(float(value) / 10e3, rel=1e-3)
    _, outcome = ran(tmp_path, PARTED + LATE)
    assert float(value) == pytest.approx(outcome.measures["late"], rel=0.02)


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('"line"\nplace = "3.3 m"', '"lin@3.3 m"', "measures.tension.tension", 'did you mean "line"'),
        ("3.3 m", "13 m", "measures.tension.place", "from 0 m to 10 m, found 13 m"),
        ('place = "3.3 m"', "", "measures.tension.tension", '"line.start", "line.end", or a place'),
        ('"line"\nplace = "3.3 m"', '"line.middle"', "measures.tension.tension",
         "expected a place on a line"),
        ("3.3 m", "3.3 kg", "measures.tension.place", "expected a length"),
        ('place = "3.3 m"', 'place = "3.3 m"\nafter = "1 s"', "measures.tension.after",
         "expected a time before the end of the run, 20 ms, found 1 s"),
        ('tension = "line"\n', 'tensoin = "line"\n', "measures.tension",
         "expected a table with height, climb, tension, bending_moment, speed, position, velocity, "
         "displacement or elevation"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_where_it_is(tmp_path, old, new, key, words):
    path = tmp_path / "scene.toml"
    path.write_text(HANGING.replace(old, new))
    with pytest.raises(SceneError) as caught:
        load_study(path)
    found = {fault.key: fault.message for fault in caught.value.faults}
    assert key in found, found
    assert words in found[key]


def test_an_end_let_go_in_water_has_no_tension(tmp_path):
    """Drag slows the end, which nothing pulls at any more."""
    text = STREAMING.replace('current = { velocity = ["5 m/s", 0, 0] }', "").replace(
        'end = "free"', 'end = { held = { pretension = "20 kN", direction = [1, 0, 0] } }'
    )
    text = (
        text.replace("tangential = 0.01", "tangential = 0.05")
        .replace("0.1 s", "10 ms")
        .replace("= 20", "= 50")
    )
    text = text.replace("0.2 s", "40 ms").replace("place = {", "#")
    text += '\n[events.cut]\nbreaks = "line.end"\ntime = "5 ms"\n'
    target, _ = ran(tmp_path, text)
    with open_result(target) as result:
        end = result.line("line").field("end_tension")[0]
        speed = np.abs(result.line("line").velocity(0)[-1, -1, 0])
    drag = 0.5 * 1000.0 * np.pi * 0.05 * 0.05 * speed**2  # N/m
    assert speed > 8.0
    assert end[0] == pytest.approx(20e3, rel=1e-9)
    # well behind the front; half a segment of 2 m is the end node's
    assert np.all(np.abs(end[-2:]) < 0.05 * drag * 1.0)


def test_an_end_that_is_let_go_carries_what_still_holds_it(tmp_path):
    """196 N of weight under 500 N: cos^2 of the force while it breaks, nothing while it falls."""
    held = "end = { held = { pretension = 500, direction = [0, 0, -1] } }"
    text = HANGING.replace('end = "free"', held).replace('"line"\nplace = "3.3 m"', '"line.end"')
    text = text.replace('"20 ms"', '"60 ms"').replace('"10 ms"', '"5 ms"')
    text += '[events.parts]\nbreaks = "line.end"\ntime = "40 ms"\n'
    target, _ = ran(tmp_path, text)
    with open_result(target) as result:
        time, ends = result.time, result.line("line").field("end_tension")[0]
        measured = result.measures()["tension"][0][0]
    left = 500.0 * np.cos(0.5 * np.pi * np.minimum(time / 0.04, 1.0)) ** 2
    np.testing.assert_allclose(ends, left, atol=1e-9)
    np.testing.assert_allclose(measured, left, atol=1e-9)
