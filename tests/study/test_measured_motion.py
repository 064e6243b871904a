"""Position, velocity and displacement of places along lines: against exact motion and the fields."""

import numpy as np
import pytest
from engine_runs import HOOKE

import lumpedcable
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.carried import missed_extremes
from lumpedcable.study.run import run_study

# the rope of 5 % stretch along (0.6, 0, 0.8), let go over 40 ms; fronts run at 1000 m/s
PLACED = (
    HOOKE.replace("direction = [1, 0, 0]", "direction = [0.6, 0, 0.8]")
    .replace("fixed = [0, 0, 0]", "fixed = [2, 3, 4]")
    .replace("time = 0", 'time = "40 ms"')
    .replace('"100 ms"', '"60 ms"')
    + """
[measures]
x = { position = "rope@91 m", component = "x" }
y = { position = "rope@91 m", component = "y" }
back = { velocity = "rope@91 m", component = "z", extreme = "least", limit = "-60 m/s" }
fast = { velocity = "rope@91 m" }
speed = { speed = "rope@91 m" }
sunk = { displacement = "rope.end", component = "z", extreme = "least" }
gone = { displacement = "rope.end" }
still = { displacement = "rope.start" }
"""
)
AT, SPEED, OVER = 91.0, 50.0, 0.04


def study_of(folder, text, *overrides):
    path = folder / "scene.toml"
    path.write_text(text)
    return load_study(path, [*overrides])


def exact(time):
    """Speed (m/s) and way (m) of what a front of v sin^2(pi t / (2 T)) has reached t s ago."""
    since = np.maximum(time, 0.0)
    t = np.minimum(since, OVER)
    way = SPEED * (0.5 * t - OVER / (2.0 * np.pi) * np.sin(np.pi * t / OVER))
    return SPEED * np.sin(0.5 * np.pi * t / OVER) ** 2, way + SPEED * (since - t)


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("motion")
    (outcome,) = run_study(study_of(folder, PLACED, "output.keep=histories"), folder / "r.h5")
    return folder / "r.h5", outcome


def test_places_move_as_the_exact_wave(measured):
    with open_result(measured[0]) as result:
        time = result.time
        found = {name: table[0] for name, (table, _) in result.measures().items()}
        ends = result.line("rope")
        end = ends.field("end_position")[0]
    speed, way = exact(time - (100.0 - AT) / 1000.0)
    near = {"rtol": 0, "atol": 2.5e-3 * way.max()}  # (h / length of the front)^2 of what moves
    np.testing.assert_allclose(found["x"], 2.0 + 0.6 * (1.05 * AT - way), **near)
    np.testing.assert_allclose(found["y"], 3.0, rtol=1e-12)
    quick = {"rtol": 0, "atol": 2.5e-3 * SPEED}
    np.testing.assert_allclose(found["back"], -0.8 * speed, **quick)
    np.testing.assert_allclose(found["fast"], speed, **quick)
    np.testing.assert_array_equal(found["fast"], found["speed"])
    np.testing.assert_allclose(found["sunk"], end[:, 2] - end[0, 2], rtol=0, atol=1e-12)
    gone = np.linalg.norm(end - end[0], axis=1)
    np.testing.assert_allclose(found["gone"], gone, rtol=0, atol=1e-12)
    assert not np.any(found["still"])


def test_a_run_has_their_extremes(measured):
    path, outcome = measured
    with open_result(path) as result:
        tables = result.measures()
    for name, (table, told) in tables.items():
        best = table.min() if name in ("back", "sunk") else table.max()
        assert outcome.measures[name] == best
        assert told["units"] == ("m/s" if name in ("back", "fast", "speed") else "m")
    assert tables["x"][1]["long_name"] == "position of rope@91 m in x"
    assert tables["back"][1]["limit"] == -60.0
    summary = lumpedcable.open(path).summary()
    assert summary.back.long_name == "least velocity of rope@91 m in z"
    assert summary.gone.long_name == "largest displacement of rope.end"


@pytest.mark.slow
def test_places_of_a_parted_line_are_what_the_fields_say(tmp_path):
    """Of every piece, on a node and between two; the places are swept like any other number."""
    text = PLACED.replace('breaks = "rope.end"', 'breaks = "rope@60 m"').replace(
        '"60 ms"', '"20 ms"'
    )
    study = study_of(tmp_path, text, "measures.x.place=[13 m, 60 m, 91 m]")
    run_study(study, tmp_path / "r.h5")
    with open_result(tmp_path / "r.h5") as result:
        found, back = (result.measures()[name][0] for name in ("x", "back"))
        for run, (name, place) in enumerate((("rope-1", 13.0), ("rope-2", 60.0), ("rope-2", 91.0))):
            nodes, line = result.line(name).unstretched_position(run), result.line(name)
            x, v = line.position(run)[..., 0], result.line("rope-2").velocity(run)[..., 2]
            own = [np.interp(place, nodes, row) for row in x]
            np.testing.assert_allclose(found[run], own, rtol=1e-12)
            along = result.line("rope-2").unstretched_position(run)
            np.testing.assert_allclose(
                back[run], [np.interp(91.0, along, row) for row in v], rtol=1e-10, atol=1e-12
            )


PAID_OUT = """
dimensions = 2
[materials.wire]
law = "linear"
EA = "1 MN"
[bodies.ship]
position = [10, 0, 0]
motion.surge = { amplitude = 0.05, period = "1.5 s", phase = "90 deg" }  # begins to move from rest
points = { post = [0, 0, 0] }
[lines.line]
material = "wire"
length = 10
segments = 4
mass = 0.02
start = { fixed = [0, 0, 0] }
end = { winch = { at = "ship.post", tension = "20 kN", inertia = 40, damping = 800 } }
[measures]
x = { position = "line@3 m", component = "x" }
gone = { displacement = "line@3 m", component = "x" }
[output]
duration = "0.4 s"
every = "20 ms"
keep = "histories"
"""


@pytest.mark.slow
def test_a_place_of_a_paid_out_line_stays_at_its_distance_from_the_start(tmp_path):
    """A wire of next to no mass is stretched alike everywhere: x(s) = s X / L, X at the post."""
    run_study(study_of(tmp_path, PAID_OUT), tmp_path / "r.h5")
    with open_result(tmp_path / "r.h5") as result:
        time, length = result.time, result.line("line").field("payout")[0]
        x, gone = (result.measures()[name][0][0] for name in ("x", "gone"))
    place = 3.0 * (10.0 + 0.05 * np.cos(2.0 * np.pi * time / 1.5)) / length
    assert np.ptp(place) > 4e-4  # the nodes beside it go 12 mm
    # what the waves of 20 g a metre leave of it
    np.testing.assert_allclose(x, place, rtol=0, atol=1e-2 * np.ptp(place))
    np.testing.assert_allclose(gone, x - x[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("entry", "key", "words"),
    [
        ('position = "rope@30 m"', "component", 'expected "x", "y" or "z", found nothing'),
        ('velocity = "rope@30 m", component = "w"', "component", 'expected "x", "y" or "z"'),
        ('velocity = "rope"', "velocity", '"rope.start", "rope.end", or a place'),
        ('displacement = "rop.end"', "displacement", 'did you mean "rope"'),
        ('displacement = "rope@130 m"', "place", "from 0 m to 100 m, found 130 m"),
        ('velocity = "rope.end", extreme = "smallest"', "extreme", '"largest" or "least"'),
        (
            'velocity = "rope.end", limit = "-3 m/s"',
            "limit",
            "expected a positive limit of a velocity",
        ),
        ('velocity = "rope.end", limit = "3 m"', "limit", "expected a speed"),
        ('speed = "rope.end", component = "x"', "component", "keys are speed, place, after, limit"),
    ],
)
def test_a_mistake_is_told_where_it_is(tmp_path, entry, key, words):
    with pytest.raises(SceneError) as caught:
        study_of(tmp_path, f"{HOOKE}\n[measures]\nmid = {{ {entry} }}\n")
    found = {fault.key: fault.message for fault in caught.value.faults}
    assert words in found[f"measures.mid.{key}"], found


@pytest.mark.parametrize(
    ("history", "told"),
    [
        ([60.0, 60.5, 61.0, 60.5], True),  # half of the 1 m that it goes through
        ([60.0, 60.95, 61.0, 60.95], False),
        ([0.1, -0.9, 0.02, -0.9], False),  # it starts there
        ([-1.0, -0.02, 0.001, -0.05], False),  # near zero, and resolved
        ([np.nan] * 4, False),
    ],
)
def test_an_extreme_of_a_coordinate_stands_out_of_its_range(tmp_path, history, told):
    mid = 'mid = { position = "rope.end", component = "x", limit = "61 m" }'
    scene = study_of(tmp_path, f"{HOOKE}\n[measures]\n{mid}\n").scene
    (said,) = missed_extremes(scene, {"mid": np.array([history])}, 1)
    assert bool(said) is told
