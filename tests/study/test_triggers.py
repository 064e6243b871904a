"""Breaks that begin at a tension: when, in which runs, what follows, and who is refused one."""

from functools import cache

import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text, scene_of
from scipy.optimize import brentq

from lumpedcable import response
from lumpedcable.fitting.load import load_fit
from lumpedcable.scene import SceneError

WIRE = """
[materials.wire]
law = "linear"
EA = "1 MN"
"""
LENGTH, AMPLITUDE, PERIOD = 50.0, 0.5, 1.0  # m, m, s; waves of 1000 m/s, impedance 1000 kg/s
# stretched by 1 %, then pulled on from rest
PULLED = WIRE + line_text(
    "rope", "wire", LENGTH, 100, 1, fixed(0, 0, 0),
    '{ motion = { position = ["51 m", 0, 0], amplitude = ["-0.5 m", 0, 0], phase = "90 deg",'
    ' period = "1 s" } }',
)  # fmt: skip


def output(duration, every="1 ms"):
    return f'[output]\nduration = "{duration}"\nevery = "{every}"\n'


def event(breaks, begins, name="part", time="5 ms"):
    return f'[events.{name}]\nbreaks = "{breaks}"\ntime = "{time}"\n{begins}\n'


def wall_tension(t):
    """Tension (N) at the fixed end by d'Alembert: 2 Z times each wave that the moved end has sent.

    A wave of velocity v meets the wall at L/c, 3 L/c, ...: at the moved end it is turned back with the
    same tension, since the end's motion is given.
    """
    rate = 2.0 * np.pi / PERIOD
    ages = t - np.arange(1, 20, 2) * LENGTH / 1000.0
    sent = np.where(ages > 0.0, AMPLITUDE * rate * np.sin(rate * ages), 0.0)
    return 1e4 + 2.0 * 1000.0 * sent.sum()


# less than at rest, three that are reached, never
LEVELS = (5e3, 11e3, 13.5e3, 16e3, 1e6)


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    """The pulled line, which breaks at its wall at each of the levels, in one batch."""
    sweep = f'[sweep]\n"events.part.tension" = {list(LEVELS)}\n'
    text = PULLED + event("rope.start", "tension = 1") + output("200 ms") + sweep
    return run_text(tmp_path_factory.mktemp("together"), text)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The same line alone, with a given beginning of the break."""

    @cache
    def ran(begins):
        text = PULLED + event("rope.start", begins) + output("200 ms")
        return run_text(tmp_path_factory.mktemp("alone"), text)

    return ran


class TestTheInstant:
    """Of a line that is pulled from rest: d'Alembert's tension at its fixed end is exact."""

    @pytest.mark.slow
    def test_is_that_of_the_exact_tension(self, together):
        for level, own, wall in zip(
            LEVELS[1:4], together.outcomes[1:4], together["rope.start_tension"][1:4], strict=True
        ):
            found = own.recoils["rope.start"]["break_start"]
            exact = brentq(lambda t, x=level: wall_tension(t) - x, 0.0, 0.25)
            np.testing.assert_allclose(found, exact, atol=2e-5)  # a step is 0.33 ms
            # the end broke under that tension: 5 ms later nothing holds it
            assert wall.max() == pytest.approx(level, rel=0.01)
            assert abs(wall[together.time > found + 6e-3]).max() < 0.1 * level

    @pytest.mark.slow
    def test_at_an_output_interval_of_many_steps(self, tmp_path):
        texts = [
            PULLED + event("rope.start", 'tension = "13 kN"') + output("200 ms", every)
            for every in ("1 ms", "50 ms")
        ]
        fine, coarse = (run_text(tmp_path, text, "solver.step=0.25 ms") for text in texts)
        starts = [ran.outcomes[0].recoils["rope.start"] for ran in (fine, coarse)]
        assert starts[0]["break_start"] == pytest.approx(starts[1]["break_start"], rel=1e-9)
        assert starts[0]["end_displacement"] == pytest.approx(
            starts[1]["end_displacement"], rel=1e-6
        )


MEETING = WIRE + "".join(
    line_text(name, "wire", 10, 8, 1, start, end)
    for name, start, end in (
        ("left", fixed(0, 0, 0), fixed(10.1, 0, 0)),
        ("right", '"left.end"', "{ motion = { position = [20.2, 0, 0], velocity = [2, 0, 0] } }"),
    )
).replace(fixed(10.1, 0, 0), '"right.start"').replace('start = "left.end"', 'start = "free"')
SIDEWAYS = WIRE + line_text(
    "rope", "wire", 10, 8, 1, fixed(0, 0, 0),
    "{ motion = { position = [8, 6.1, 0], velocity = [2, 1, 0] } }",
)  # fmt: skip
ON_A_SHIP = (
    WIRE
    + """
[bodies.ship]
position = [10.2, 0, 0]
points = { post = [0, 0, 0] }
motion = { surge = { amplitude = "0.3 m", period = "1 s" } }
"""
    + line_text("rope", "wire", 10, 8, 1, fixed(0, 0, 0), '"ship.post"')
)


def follows(mine, given, tight):
    """A run is that of a scene that gives the same start."""
    assert mine.outcomes[0].recoils.keys() == given.outcomes[0].recoils.keys()
    for end, numbers in given.outcomes[0].recoils.items():
        for name, value in numbers.items():
            own = mine.outcomes[0].recoils[end][name]
            assert own == pytest.approx(value, rel=tight, nan_ok=True), f"{end}: {name}"
    for line in given.lines:
        for quantity, values in given.lines[line].items():
            size = np.abs(values).max()
            found = mine.lines[line][quantity]
            np.testing.assert_allclose(found, values, atol=tight * size, err_msg=quantity)
    assert mine.outcomes[0].energy_closure == pytest.approx(
        given.outcomes[0].energy_closure, rel=1e-3, abs=tight
    )


class TestWhatFollows:
    """The run is that of the scene that gives the same start."""

    @pytest.mark.slow
    def test_as_of_a_given_start(self, alone):
        mine = alone(f"tension = {LEVELS[1]}")
        start = mine.outcomes[0].recoils["rope.start"]["break_start"]
        assert 4e-3 < start < 0.1
        follows(mine, alone(f"start = {start!r}"), 1e-9)

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("scene", "breaks", "tension", "more"),
        [
            (PULLED, "rope.end", 11e3, ("solver.method=rk4",)),
            (PULLED, "rope@20 m", 11e3, ()),
            (MEETING, "left.end", 18e3, ()),
            (SIDEWAYS, "rope.start", 18e3, ()),
            (ON_A_SHIP, "rope.end", 24e3, ("solver.dtype=float32",)),
        ],
        ids=["motion", "along", "joint", "two dimensions", "body"],
    )
    def test_as_of_a_given_start_anywhere(self, tmp_path, scene, breaks, tension, more):
        tail = output("120 ms", "4 ms")
        mine = run_text(tmp_path, scene + event(breaks, f"tension = {tension}") + tail, *more)
        start = next(iter(mine.outcomes[0].recoils.values()))["break_start"]
        assert 4e-3 < start < 0.1
        given = run_text(tmp_path, scene + event(breaks, f"start = {start!r}") + tail, *more)
        follows(mine, given, 1e-5 if more == ("solver.dtype=float32",) else 1e-9)

    @pytest.mark.slow
    def test_what_breaks_first_loads_what_is_left(self, tmp_path):
        # a weight on three wires: those at the sides hold until the middle one is cut
        wires = {"left": -4.0, "middle": 0.0, "right": 4.0}
        text = "gravity = 10\n" + WIRE + '[bodies.bob]\nmass = "1 t"\n'
        for name, x in wires.items():
            text += line_text(name, "wire", np.hypot(x, 3.0), 6, 0.1, fixed(x, 0, 3), '"bob"')
        text += event("middle.end", 'start = "20 ms"', "cut")
        text += event("left.end", 'tension = "7 kN"', "left")
        text += event("right.start", 'tension = "1 MN"', "right")
        ran = run_text(tmp_path, text + output("200 ms"))
        found = ran.outcomes[0].recoils
        assert found["middle.end"]["break_start"] == 0.02
        left = ran["left.end_tension"][0]
        reached = ran.time[np.argmax(left > 6.9e3)]
        assert 0.02 < found["left.end"]["break_start"] == pytest.approx(reached, abs=2e-3)
        assert "right.start" not in found  # it never has to carry as much
        assert ran["right.tension"].max() < 1e6
        assert ran.outcomes[0].status.name == "OK"


class TestRunsOfABatch:
    @pytest.mark.slow
    def test_each_at_its_own_time_or_never(self, together, alone):
        at_once, later, *_, never = together.outcomes
        assert at_once.recoils["rope.start"]["break_start"] == 0.0
        assert later.recoils["rope.start"]["break_start"] > 0.05
        assert never.recoils == {}
        assert {own.status.name for own in together.outcomes} == {"OK"}
        # and as each alone
        for k, level in enumerate(LEVELS):
            same = alone(f"tension = {level}")["rope.position"][0]
            np.testing.assert_allclose(together["rope.position"][k], same, atol=1e-9)
        # what begins at rest is what a start of 0 s is
        given = alone("start = 0")
        np.testing.assert_allclose(
            together["rope.position"][0], given["rope.position"][0], atol=1e-9
        )


class TestRefused:
    @pytest.mark.parametrize(
        ("text", "words"),
        [
            (
                PULLED + event("rope.start", 'tension = "12 kN"\nstart = "1 s"'),
                "expected one beginning, at a time or at a tension, found start and tension",
            ),
            (
                WIRE
                + line_text(
                    "rope", "wire", 10, 8, 1, fixed(0, 0, 0),
                    '{ held = { pretension = "45 kN", direction = [1, 0, 0] } }',
                )
                + event("rope.end", 'tension = "50 kN"'),
                "which a force of 45 kN holds whatever happens: give start",
            ),
            (
                PULLED
                + event("rope.start", 'tension = "12 kN"')
                + '[solver]\nmethod = "tsit5"\n',
                'expected fixed steps where a break begins at a tension (leapfrog, rk4 or '
                'solver.step), found solver.method = "tsit5"',
            ),
            (PULLED + event("rope.start", 'tension = "0 N"'), "expected a positive force (N)"),
        ],
        ids=["start as well", "a force", "adaptive", "zero"],
    )  # fmt: skip
    def test_with_the_reason(self, tmp_path, text, words):
        with pytest.raises(SceneError) as told:
            scene_of(tmp_path, text + output("1 s"))
        assert words in str(told.value)

    def test_derivatives(self, tmp_path):
        scene = tmp_path / "scene.toml"
        scene.write_text(PULLED + event("rope.start", 'tension = "12 kN"') + output("0.1 s"))
        words = r"expected breaks that begin at a time \(start\), found events\.part, .* 12 kN"
        with pytest.raises(SceneError, match=words):
            response(scene, by=["EA"], of="max velocity at rope.start")

    def test_fits(self, tmp_path):
        (tmp_path / "scene.toml").write_text(
            PULLED + event("rope.start", 'tension = "12 kN"') + output("0.1 s")
        )
        (tmp_path / "data.csv").write_text("t (s),T (N)\n0,10000\n0.05,10000\n0.1,11000\n")
        (tmp_path / "fit.toml").write_text("""
scene = "scene.toml"
[free]
"materials.wire.EA" = { start = "1.1 MN" }
[experiments.pull]
file = "data.csv"
time = { column = "t (s)" }
observe = [{ quantity = "tension", at = "rope.start", column = "T (N)", noise = "10 N" }]
""")
        with pytest.raises(SceneError, match="expected breaks that begin at a time"):
            load_fit(tmp_path / "fit.toml")
