"""A peak speed above the exact one comes from the mesh, and is told where that one is a bound."""

import numpy as np
import pytest
from engine_runs import HOOKE, NYLON, scene_of, study_of

from lumpedcable.exact import release_wave
from lumpedcable.study.laying import lay_out
from lumpedcable.study.run import run_runs, run_study
from lumpedcable.study.speeds import allowance, excess_words

# 60 m in water that weigh 2.2 N/m and bear 45 kN: in 50 ms that makes 0.05 m/s
LINE = """
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
[materials.nylon]
law = "linear"
EA = "1.5 MN"
tension_only = true
[lines.rope]
material = "nylon"
length = "60 m"
segments = 20
mass = "2.238 kg/m"
diameter = "50 mm"
drag = { normal = 1.5, tangential = 0.01 }
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "45 kN", direction = [1, 0, 0] } }
[events.break]
breaks = "rope.end"
time = "5 ms"
[output]
duration = "50 ms"
every = "1 ms"
"""


SWEEP = """
[sweep]
"lines.rope.segments" = {}
"lines.rope.end.held.pretension" = ["45 kN", "450 kN"]
"events.break.time" = [0, "0.1 ms", "5 ms"]
"""


SPEED = "summary/rope.end/peak_end_speed"


def told_by(folder, text, *, exact):
    """The table of all runs, with exact waves or as a study does it, and what is said of them."""
    laid = lay_out(study_of(folder, text))
    runs = np.arange(len(laid.study.runs))
    ((_, table),) = run_runs(laid, runs, folder / "result.h5", exact=exact)
    return table, table["status_message"].tolist()


@pytest.fixture(scope="module")
def linear(tmp_path_factory):
    """Runs of 20 segments, then of 50; of each, of 45 kN and then of 450 kN, three breaks."""
    return told_by(tmp_path_factory.mktemp("linear"), LINE + SWEEP.format([20, 50]), exact=True)


@pytest.mark.parametrize(("run", "told"), [(2, True), (8, False)])
@pytest.mark.slow
def test_too_few_segments_are_told_by_the_speed(linear, run, told):
    table, said = linear
    exact = 45e3 / np.sqrt(1.5e6 * 2.238)  # T / sqrt(EA m)
    known, speed = (
        table[f"summary/rope.end/{name}"][run]
        for name in ("exact_peak_end_speed", "peak_end_speed")
    )
    assert known == pytest.approx(exact, rel=1e-6)
    more = speed / exact - 1.0
    assert (more > 0.05 + 0.05 / exact) == told
    words = f"peak end speed of rope.end is {100 * more:.0f} % above the exact bound: take more segments"
    assert said[run] == (f"ok; {words}" if told else "ok")


def test_a_study_says_it_too(tmp_path, linear):
    table, said = linear
    again, alone = told_by(tmp_path, LINE + SWEEP.format([20, 50]), exact=False)
    np.testing.assert_array_equal(again[SPEED], table[SPEED])
    # the bound of a straight line is its speed
    assert 0 < sum(one != "ok" for one in said) < len(said)
    assert alone == said


@pytest.mark.slow
def test_a_study_says_no_more_of_another_law(tmp_path):
    text = LINE[: LINE.index("[materials")] + NYLON + LINE[LINE.index("[lines") :]
    text += SWEEP.format([10])
    (table, said), (again, alone) = (told_by(tmp_path, text, exact=x) for x in (True, False))
    np.testing.assert_array_equal(again[SPEED], table[SPEED])
    for one, other in zip(alone, said, strict=True):
        assert one in ("ok", other)


@pytest.mark.parametrize(
    ("run", "advice"),
    [
        (
            0,
            "a break at once overshoots at first on any mesh: give events.break.time what it takes",
        ),
        (
            1,
            "the wave takes longer through a segment than events.break.time, 100 µs: take more segments",
        ),
        (2, "take more segments"),
    ],
)
def test_what_helps_is_said_by_how_sudden_a_break_is(linear, run, advice):
    # the wave takes 3 m / 819 m/s = 3.7 ms in a segment
    assert f"above the exact bound: {advice}" in linear[1][run]


def allowed(folder, text, *overrides):
    scene = scene_of(folder, text, *overrides)
    material, own = scene.materials["hooke"], scene.lines["rope"]
    cut = (
        (lambda e: np.maximum(material.curve(e), 0.0)) if material.tension_only else material.curve
    )
    wave = release_wave(cut, own.mass, tension0=50e3)
    return allowance(scene, "rope", own.length, wave, 0.0)


POLYNOMIAL = HOOKE.replace(
    'law = "linear"\nEA = "1 MN"', 'law = "polynomial"\ncoefficients = ["1 MN", "2 MN"]'
)


FLOATING = "gravity = 9.81\n[water]\ndensity = 1000\n" + HOOKE.replace(
    "mass =", f"diameter = {np.sqrt(4.0 * 3e-3 / np.pi)}\nmass ="
)


@pytest.mark.parametrize(
    ("text", "more", "expected"),
    [
        (HOOKE, (), 0.0),
        ("gravity = 9.81\n" + HOOKE, (), 0.981),  # in 100 ms
        ("gravity = 9.81\n" + HOOKE, ("output.duration=1 s",), np.inf),
        # in water whose push is three times its weight it goes up with twice the acceleration
        (FLOATING, (), 2 * 0.981),
        ("gravity = 9.81\n" + HOOKE, ("lines.rope.mass=3",), np.inf),  # 2943 N beside 50 kN
        (
            HOOKE.replace("fixed = [0", "motion = { position = [0", 1).replace("0] }", "0] } }", 1),
            (),
            np.inf,
        ),
        (HOOKE.replace("{ fixed = [0, 0, 0] }", '"free"'), (), np.inf),
        (HOOKE + '[solver]\nwaves = "plain"\n', (), np.inf),
        # a law that is no straight line may do more once the front is back, after some 0.2 s
        (POLYNOMIAL, (), 0.0),
        (POLYNOMIAL, ("output.duration=300 ms",), np.inf),
        (POLYNOMIAL, ("output.duration=300 ms", "materials.hooke.tension_only=true"), 0.0),
    ],
)
def test_where_the_exact_speed_is_a_bound(tmp_path, text, more, expected):
    assert allowed(tmp_path, text, *more) == pytest.approx(expected)


# as much fluid goes along with it as makes 4 kg/m of 1: 500 m/s, and 25 m/s where it is let go
HEAVY = HOOKE.replace("mass =", f"""diameter = {np.sqrt(4.0 * 12e-3 / np.pi)}
added_mass = {{ normal = 1.0, tangential = 0.25 }}
mass =""")  # fmt: skip


def test_fluid_that_goes_along_slows_the_exact_wave(tmp_path):
    text = "[water]\ndensity = 1000\n" + HEAVY
    (outcome,) = run_study(study_of(tmp_path, text, "output.duration=10 ms"), tmp_path / "r.h5")
    numbers = outcome.recoils["rope.end"]
    assert numbers["exact_peak_end_speed"] == pytest.approx(50e3 / np.sqrt(1e6 * 4.0), rel=1e-9)
    assert numbers["exact_front_arrival"] == pytest.approx(100.0 / np.sqrt(1e6 / 4.0), rel=1e-9)
    # it lets go at once, which overshoots: known by itself, as a study does, as beside the exact wave
    runs = lay_out(study_of(tmp_path, text, "output.duration=10 ms"))
    ((_, table),) = run_runs(runs, np.arange(1), tmp_path / "alone.h5", exact=False)
    assert "above the exact bound" in outcome.message
    assert table["status_message"].tolist() == [outcome.message]


def test_weight_hastens_what_moves_and_not_the_line_alone(tmp_path):
    # 1 kg/m in 12 kg/m of water is pushed up by 11 g N/m, which moves 4 kg/m, in 1 ms
    text = "gravity = 9.81\n[water]\ndensity = 1000\n" + HEAVY
    scene = scene_of(tmp_path, text, "output.duration=1 ms", "rope.length=10 m")
    wave = release_wave(scene.materials["hooke"].curve, 4.0, tension0=50e3)
    assert allowance(scene, "rope", 10.0, wave, 0.0) == pytest.approx(11 * 9.81 / 4.0 * 1e-3)


def test_a_twentieth_more_and_what_weight_adds_is_not_told():
    assert excess_words("rope.end", 21.0, 20.0, 0.0) == ""
    assert excess_words("rope.end", 21.4, 20.0, 0.5) == ""
    assert excess_words("rope.end", 99.0, 20.0, np.inf) == ""
    assert excess_words("rope.end", np.nan, 20.0, 0.0) == ""
    assert "is 12 % above" in excess_words("rope.end", 22.4, 20.0, 0.5)
