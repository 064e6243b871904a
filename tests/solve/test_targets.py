"""Statics that meets targets by choosing lengths, against closed forms of inextensible lines."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.exact import (
    dragged_from_tension,
    highline_from_length,
    highline_from_sag,
    highline_from_tension,
    loaded_from_length,
)
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.scene import read_scene
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.targets import rest_of, sag_of
from lumpedcable.study.compiled import Structure, prepare_batch

SPAN, DROP, WEIGHT, LOAD = 60.0, 16.0, 40.0, 20e3
START, END = {"fixed": [0, 0, 0]}, {"fixed": [60, 0, -16]}
UP = jnp.array([0.0, 1.0])


def scene(lines, targets=None, bodies=None, EA=75e9):
    """A scene at rest: lines by name (length, start, end, segments, mass)."""
    found, problems = read_scene(
        {
            "gravity": 10.0,
            "materials": {"wire": {"law": "linear", "EA": EA, "tension_only": True}},
            "bodies": bodies or {},
            "lines": {
                name: {
                    "material": "wire", "length": length, "start": start, "end": end,
                    "segments": segments, "mass": mass,
                }
                for name, (length, start, end, segments, mass) in lines.items()
            },
            "targets": targets or {},
            "output": {},
        }
    )  # fmt: skip
    assert found is not None, problems
    return found


def at_rest(mine, **swept):
    """The state of rest of runs that differ in the numbers given, dots written as __."""
    layout, coordinates = make_layout(mine), coordinates_of([mine])
    moved = {key.replace("__", "."): np.asarray(value, float) for key, value in swept.items()}
    runs = len(next(iter(moved.values())))
    moved["output.duration"] = np.zeros(runs)  # as studies do: the same program as theirs
    shared = {k: jnp.asarray(v) for k, v in mine.numbers().items() if k not in moved}
    structure = Structure(mine.skeleton(), layout, mine)
    ready = prepare_batch(structure, "float64", coordinates.axes, coordinates.origin, shared, moved)
    assert np.all(ready.converged)
    return ready.model


def length(line):
    return np.asarray(line.segment_length)[:, 0] * (line.reference.shape[-1] - 1)


def hanging(segments):
    return scene({"line": (63.34896, START, END, segments, 4.0)})


def winched(segments):
    target = {"change": "lines.line.length", "of": "line.start", "tension": 80e3}
    return scene({"line": (62.2, START, END, segments, 4.0)}, {"winch": target})


def delivered(segments):
    return scene(
        {
            "before": (28.0, START, "cargo", segments, 4.0),
            "after": (34.5, "cargo", END, segments, 4.0),
        },
        {
            "cargo": {"change": "lines.before.length", "of": "cargo", "x": 30.0},
            "whole": {"change": "lines.after.length", "of": "before + after", "length": 62.5},
        },
        {"cargo": {"mass": 2000.0}},
    )


@pytest.mark.slow
def test_a_hanging_line_converges_at_second_order():
    exact = highline_from_length(SPAN, DROP, WEIGHT, 63.34896)
    wanted = [exact.sag, exact.tension_a, exact.tension_b]
    errors = []
    for segments in (16, 32):
        line = at_rest(hanging(segments), gravity=[10.0]).lines["line"]
        one = jax.tree.map(lambda x: x[0], line)
        found = [sag_of(one.reference, UP), tension_at(one, 0), tension_at(one, -1)]
        errors.append(np.array(found) / wanted - 1.0)
    # (h/l)^2 / 24 q^2 l^2/H^2 and the like: below a per mille with 32 segments
    assert np.all(np.abs(errors[1]) < 1e-3)
    assert errors[0] / errors[1] == pytest.approx(np.full(3, 4.0), rel=0.05)


@pytest.mark.slow
def test_cargo_converges_at_second_order():
    places = np.array([10.0, 30.0])
    exact = loaded_from_length(SPAN, DROP, WEIGHT, LOAD, places, 62.5)
    # what the stretch of T/EA adds to the slack, to first order, is told by a line that much longer
    longer = loaded_from_length(
        SPAN, DROP, WEIGHT, LOAD, places, 62.5 * (1.0 + exact.tension_a / 75e9)
    )
    stretch = np.abs(longer.tension_a / exact.tension_a - 1.0)
    errors = []
    for segments in (2, 4):
        model = at_rest(delivered(segments), targets__cargo__x=places)
        before, after = model.lines["before"], model.lines["after"]
        assert length(before) + length(after) == pytest.approx(62.5, rel=1e-12)
        assert before.reference[:, 0, -1] == pytest.approx(places, abs=1e-9)
        tension = jax.vmap(lambda line: tension_at(line, 0))(before)
        errors.append(np.asarray(tension) / exact.tension_a - 1.0)
    assert np.all(np.abs(errors[1]) < 5e-3)
    # less the stretch, which no mesh mends
    mesh = [np.abs(e + stretch) for e in errors]
    assert mesh[0] / mesh[1] == pytest.approx(np.full(2, 4.0), rel=0.15)


@pytest.mark.slow
def test_a_winch_and_the_limit_of_no_stretch():
    EA = 75e6 * np.array([10.0, 100.0, 1000.0])  # 75 MN is a real rope's
    line = at_rest(winched(32), materials__wire__EA=EA).lines["line"]
    assert jax.vmap(lambda one: tension_at(one, 0))(line) == pytest.approx(80e3, rel=1e-8)
    found = length(line)
    exact = highline_from_tension(SPAN, DROP, WEIGHT, 80e3).length
    # the unstretched length is shorter by the strain, about T/EA, and so first order in 1/EA
    assert found[2] == pytest.approx(exact, rel=3e-6)
    short = exact - found
    assert short[0] / (exact * 80e3 / EA[0]) == pytest.approx(1.0, abs=0.02)
    steps = found[1:] - found[:-1]
    assert steps[0] / steps[1] == pytest.approx(10.0, rel=1e-2)


@pytest.mark.slow
def test_derivatives_go_through_targets():
    mine = winched(8)
    layout, coordinates = make_layout(mine), coordinates_of([mine])
    numbers = {key: jnp.asarray(value) for key, value in mine.numbers().items()}

    def end(tension):
        values = {**numbers, "targets.winch.tension": tension}
        line = rest_of(mine.with_numbers(values), layout, coordinates).model.lines["line"]
        return jnp.stack([8.0 * line.segment_length[0], tension_at(line, -1)])

    at = jnp.asarray(80e3)
    found = jax.jit(lambda T: jax.jvp(end, (T,), (jnp.ones(()),))[1])(at)
    # F_TA - F_TB = q c whatever the tension, and dS/dF_TA of the closed form
    exact = highline_from_tension(SPAN, DROP, WEIGHT, 80e3 + 1e-30j)
    assert found[1] == pytest.approx(1.0, abs=1e-3)
    slope = float(np.imag(exact.length)) / 1e-30 - 62.1 / 75e9  # less the stretch
    assert found[0] == pytest.approx(slope, rel=0.03)


@pytest.mark.slow
def test_a_line_dragged_across():
    lines = {
        "line": (30.0, START, "tow.start", 32, 4.0),
        "tow": (33.0, "line.end", END, 32, 0.5),
    }
    target = {"change": "lines.tow.length", "of": "tow.end", "tension": 4e3}
    paid_out = np.array([14.0, 34.0, 54.0])
    model = at_rest(scene(lines, {"haul": target}), lines__line__length=paid_out)
    exact = dragged_from_tension(SPAN, DROP, WEIGHT, paid_out, 5.0, 4e3)
    joint = np.asarray(model.lines["tow"].reference[:, :, 0])
    assert np.max(np.abs(joint.T / np.array(exact.middle) - 1.0)) < 1e-4
    assert length(model.lines["tow"]) == pytest.approx(exact.parts[1].length, rel=2e-4)


@pytest.mark.slow
def test_the_taut_line_is_meant_unless_the_slack_one_is_near():
    target = {"change": "lines.line.length", "of": "line.start", "tension": 80e3}
    mine = scene({"line": (92.5, START, END, 16, 3.35)}, {"winch": target})
    found = length(at_rest(mine, targets__winch__tension=[80e3, 3e3]).lines["line"])
    exact = highline_from_tension(SPAN, DROP, 33.5, np.array([80e3, 3e3])).length
    # 16 chords: of the order of (1/16)^2 of a per cent of slack at 80 kN
    assert found[0] == pytest.approx(exact[0], rel=1e-5)
    assert found[1] == pytest.approx(exact[1], rel=1e-3)


@pytest.mark.slow
def test_cargo_near_a_post_is_found_from_guesses_far_from_there():
    mass = 3383.978
    exact = loaded_from_length(SPAN, DROP, WEIGHT, 10.0 * mass, 5.0, 62.5)
    model = at_rest(delivered(32), targets__cargo__x=[5.0], bodies__cargo__mass=[mass])
    assert tension_at(jax.tree.map(lambda x: x[0], model.lines["before"]), 0) == pytest.approx(
        float(exact.tension_a), rel=1e-3
    )
    for name, part in zip(("before", "after"), exact.parts, strict=True):
        assert length(model.lines[name])[0] == pytest.approx(float(part.length), rel=1e-4)


@pytest.mark.slow
def test_cargo_on_a_line_much_longer_than_its_first_guess():
    """On the way there all of the wire is slack, and what rounding leaves is that of a taut one."""
    places, whole = np.array([30.0, 35.0]), 100.0
    exact = loaded_from_length(SPAN, DROP, WEIGHT, LOAD, places, whole)
    swept = {"targets__cargo__x": places, "targets__whole__length": [whole, whole]}
    line = at_rest(delivered(16), **swept).lines["before"]
    found = jax.vmap(lambda one: tension_at(one, 0))(line)
    # 16 chords a part: of the order of (1/16)^2 of what the wire's own weight does
    assert found == pytest.approx(exact.tension_a, rel=1e-4)


@pytest.mark.slow
def test_sags_of_taut_and_of_slack_lines():
    target = {"change": "lines.line.length", "of": "line", "sag": 5.0}
    mine = scene({"line": (63.0, START, END, 8, 4.0)}, {"deflection": target})
    sags = np.array([0.5, 1.0, 2.0, 5.0, 20.0])
    found = length(at_rest(mine, targets__deflection__sag=sags).lines["line"])
    # 8 chords: a few (1/8)^2 of the slack, at most, beside what a taut one stretches
    exact = highline_from_sag(SPAN, DROP, WEIGHT, sags)
    slack = exact.length - np.hypot(SPAN, DROP)
    assert np.all(np.abs(found / (1.0 - exact.tension_a / 75e9) - exact.length) < slack * 0.05)


@pytest.mark.slow
def test_a_line_shrunk_to_nothing_hides_no_miss():
    """Between the cargo and its post 1e-13 m of wire pulls with 6e10 N: 0.1 m seem little."""
    mine = delivered(32)
    layout, coordinates = make_layout(mine), coordinates_of([mine])
    numbers = {key: jnp.asarray(value) for key, value in mine.numbers().items()}
    run = jax.jit(lambda n: rest_of(mine.with_numbers(n), layout, coordinates))
    shrunk = {"lines.before.length": 62.6011, "targets.cargo.x": 5.0}
    for last in (1e-6, 1e-9, 1e-12):
        found = run({**numbers, **{k: jnp.asarray(v) for k, v in shrunk.items()},
                     "lines.after.length": jnp.asarray(last)})  # fmt: skip
        whole = sum(float(length_of(found.model.lines[name])) for name in ("before", "after"))
        assert not found.converged or whole == pytest.approx(62.5, rel=1e-9)


def length_of(line):
    return jnp.sum(line.segment_length * jnp.ones(line.reference.shape[-1] - 1))
