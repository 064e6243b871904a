"""Breaks at either end, at joints, along the line, now and later."""

import numpy as np
import pytest
from engine_runs import HOOKE, ROPE, fixed, line_text, run_text, scene_of
from nylon_line import MASS, cut

from lumpedcable.exact import LinearRelease, release_wave
from lumpedcable.model.layout import make_layout
from lumpedcable.scene import SceneError
from lumpedcable.study.outcome import EXACT
from lumpedcable.study.plan import recoil_names

FIXED = 'end = { fixed = ["66 m", 0, 0] }'  # 10 % longer than it is unstretched


def ends_fixed(text):
    """The same line between two walls."""
    held = 'end = { held = { pretension = "45 kN", direction = [1, 0, 0] } }'
    assert held in text
    return text.replace(held, FIXED)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The nylon line between two walls, stretched by 10 %, parting at 37.5 m of 60 m."""
    text = ROPE.replace("tension_only = false", "tension_only = true")
    text = ends_fixed(text).replace('breaks = "rope.end"', 'breaks = "rope@37.5 m"')
    folder = tmp_path_factory.mktemp("cut")
    return run_text(folder, text, "rope.segments=400", "output.duration=50 ms")


class TestAlongTheLine:
    @pytest.mark.slow
    def test_two_pieces_of_the_right_length(self, ran):
        assert list(ran.lines) == ["rope-1", "rope-2"]
        assert ran["rope-1.tension"].shape[-1] + ran["rope-2.tension"].shape[-1] == 400
        assert ran.places["rope-1"][-1] == pytest.approx(37.5, rel=1e-12)
        assert ran.places["rope-2"][0] == pytest.approx(37.5, rel=1e-12)
        assert ran.places["rope-2"][-1] == pytest.approx(60.0, rel=1e-12)
        # until it breaks the two ends are one point
        left, right = ran["rope-1.position"][0, 0, -1], ran["rope-2.position"][0, 0, 0]
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-12)
        np.testing.assert_allclose(left, [37.5 * 1.1, 0.0, 0.0], atol=1e-9)

    def test_each_recoils_at_the_exact_speed(self, ran):
        # both pieces see the same release, each from its own end: a rarefaction of 10 % strain
        wave = release_wave(cut, MASS, strain0=0.1)
        after = ran.time > 7e-3
        for name, node, sign in (("rope-1", -1, -1.0), ("rope-2", 0, 1.0)):
            speed = sign * ran[f"{name}.velocity"][0, after, node, 0]
            assert speed.mean() == pytest.approx(wave.end_speed, rel=1e-3)

    def test_momentum_of_each_piece_is_the_impulse_on_it(self, ran):
        # until the fronts reach the walls: d(sum m v)/dt is wall tension less what still holds
        start = ran["rope-1.start_tension"][0, 0]
        held = start * np.where(ran.time < 5e-3, np.cos(np.pi * ran.time / 10e-3) ** 2, 0.0)
        impulse = np.concatenate(
            [[0.0], np.cumsum(0.5 * ((start - held)[1:] + (start - held)[:-1]) * np.diff(ran.time))]
        )
        for name, sign, length in (("rope-1", -1.0, 37.5), ("rope-2", 1.0, 22.5)):
            v = ran[f"{name}.velocity"][0, :, :, 0]
            n = v.shape[1] - 1
            momentum = MASS * length / n * (v.sum(axis=1) - 0.5 * (v[:, 0] + v[:, -1]))
            quiet = ran.time < 30e-3  # the front needs 22.5 m / 661 m/s = 34 ms
            # the impulse is integrated from 1 ms samples: good to the corners of the ramp
            np.testing.assert_allclose(
                sign * momentum[quiet], impulse[quiet], rtol=0, atol=2e-3 * impulse[quiet][-1]
            )

    def test_energy_closes(self, ran):
        assert ran.outcomes[0].energy_closure < 2e-4
        assert ran.statuses == ["OK"]


@pytest.mark.slow
def test_a_cut_is_not_felt_before_the_break(tmp_path):
    # the same line, whole or cut at 37.5 m, shaken at one end: nothing breaks in the first 60 ms
    shaken = HOOKE.replace(
        'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
        'end = { motion = { position = [105, 0, 0], amplitude = [0.3, 0, 0], period = "20 ms",'
        ' ramp = "30 ms" } }',
    ).replace('breaks = "rope.end"', 'breaks = "rope@37.5 m"')
    options = '\n[solver]\nwaves = "plain"\n'
    short = ("output.duration=61 ms", "rope.segments=40")
    broken = run_text(tmp_path, shaken + options, "break.start=60.5 ms", *short)
    event = shaken[shaken.index("[events") : shaken.index("[output]")]
    whole = run_text(tmp_path, shaken.replace(event, "") + options, *short)
    assert list(broken.lines) == ["rope-1", "rope-2"]
    both = np.concatenate([broken["rope-1.velocity"], broken["rope-2.velocity"][:, :, 1:]], axis=2)
    assert np.max(np.abs(whole["velocity"])) > 50.0
    np.testing.assert_allclose(both[:, :61], whole["velocity"][:, :61], rtol=0, atol=1e-9)


LATER = {
    "held end": (HOOKE, "rope.end"),
    "fixed end": (
        HOOKE.replace(
            'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
            "end = { fixed = [105, 0, 0] }",
        ),
        "rope.end",
    ),
    "fixed start": (HOOKE, "rope.start"),
    "along the line": (
        HOOKE.replace(
            'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
            "end = { fixed = [105, 0, 0] }",
        ),
        "rope@40 m",
    ),
}


# each is a program of its own
SOME_LATER = [
    pytest.param(*case, marks=[] if name == "held end" else pytest.mark.slow)
    for name, case in LATER.items()
]


@pytest.mark.parametrize(("text", "place"), SOME_LATER, ids=LATER.keys())
@pytest.mark.parametrize("time", [pytest.param("0 ms", marks=pytest.mark.slow), "4 ms"])
def test_a_later_break_is_the_same_break_later(tmp_path, text, place, time):
    if place == "rope.start":  # what is left must be held by something else than a force
        text = text.replace(
            'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
            "end = { fixed = [105, 0, 0] }",
        )
    text = text.replace('breaks = "rope.end"', f'breaks = "{place}"')
    options = (f"break.time={time}", "output.duration=60 ms")
    now = run_text(tmp_path, text, *options)
    later = run_text(tmp_path, text, *options, "break.start=20 ms")
    assert now.statuses == later.statuses == ["OK"]
    for name, line in now.lines.items():
        # nothing moves before
        still = later.lines[name]
        assert np.max(np.abs(still["velocity"][0, :20])) < 1e-9
        assert np.max(np.abs(still["position"][0, :20] - still["position"][0, 0])) < 1e-9
        # and then all goes as it went: a break in no time begins within a step
        for quantity, size in (("position", 1.0), ("velocity", 50.0), ("tension", 50e3)):
            a, b = line[quantity][0, :-20], still[quantity][0, 20:]
            if time == "4 ms":
                np.testing.assert_allclose(a, b, rtol=0, atol=1e-3 * size)
            elif quantity == "position":
                # a break in no time takes hold with the kick centred on it, half a step early
                np.testing.assert_allclose(a, b, rtol=0, atol=50.0 * now.outcomes[0].solver_step)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "length", "name"), [("rope.end", 100.0, "rope"), ("rope@40 m", 40.0, "rope-1")]
)
def test_a_break_against_all_its_reflections(tmp_path, place, length, name):
    # the linear line by d'Alembert, 20 ms to break: what is left of it is 100 m or 40 m long
    text = LATER["fixed end"][0].replace('breaks = "rope.end"', f'breaks = "{place}"')
    ran = run_text(
        tmp_path, text, "break.time=20 ms", "rope.segments=100", "output.duration=150 ms"
    )
    exact = LinearRelease(length, 1e6, 1.0, 50e3, 20e-3)
    moved = ran[f"{name}.position"][0, 0, -1, 0] - ran[f"{name}.position"][0, :, -1, 0]
    np.testing.assert_allclose(moved, exact.end_displacement(ran.time), atol=2e-3)


@pytest.mark.slow
def test_a_body_that_a_line_breaks_away_from(tmp_path):
    # a mass between two lines, in balance; one breaks: the mass is pulled away by the other
    text = """
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.left]
material = "hooke"
length = "10 m"
segments = 10
mass = "0.01 kg/m"
start = { fixed = [0, 0, 0] }
end = "bob"
[lines.right]
material = "hooke"
length = "10 m"
segments = 10
mass = "0.01 kg/m"
start = "bob"
end = { fixed = [21, 0, 0] }
[bodies.bob]
mass = "1000 kg"
[events.break]
breaks = "right.start"
time = 0
[output]
duration = "100 ms"
every = "1 ms"
"""
    ran = run_text(tmp_path, text)
    # M x'' = -k (x - 10 m) with k = EA / L from 10.5 m, the light line following
    omega = np.sqrt(1e6 / 10.0 / 1000.0)
    expected = 10.0 + 0.5 * np.cos(omega * ran.time)
    np.testing.assert_allclose(ran["left.position"][0, :, -1, 0], expected, atol=2e-3 * 0.5)
    # and the end that broke away is no longer at the mass
    assert ran["right.position"][0, -1, 0, 0] > ran["left.position"][0, -1, -1, 0] + 0.1


def test_more_breaks_than_segments(tmp_path):
    text = HOOKE.replace('breaks = "rope.end"', 'breaks = "rope@40 m"')
    with pytest.raises(SceneError, match="too few segments"):
        run_text(tmp_path, text, "rope.segments=1")


def test_two_breaks_at_one_node_are_named(tmp_path):
    event = 'breaks = "rope@40 m"\ntime = "2 ms"\n'
    text = HOOKE.replace('breaks = "rope.end"', 'breaks = "rope@42 m"') + f"[events.other]\n{event}"
    with pytest.raises(SceneError, match='"other" and "break" break it at one node'):
        run_text(tmp_path, text, "rope.segments=10")


@pytest.mark.slow  # that of another line is among the quick ones
def test_the_far_end_feels_no_break_of_its_own(tmp_path):
    # waves of 1000 m/s along 20 m; the part between the breaks is 6 m long
    ran = run_text(
        tmp_path,
        """
[materials.m]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "m"
length = 20
segments = 40
mass = 1
start = { fixed = [0, 0, 0] }
end = { fixed = [21, 0, 0] }
[events.first]
breaks = "rope@4 m"
start = "3 ms"
time = "0.5 ms"
[events.second]
breaks = "rope@10 m"
start = "5 ms"
time = "0.5 ms"
[output]
duration = "20 ms"
every = "1 ms"
""",
    )
    felt = {end: found["front_arrival"] for end, found in ran.outcomes[0].recoils.items()}
    # a front is a segment wide, 0.5 ms
    assert felt["rope-1.end"] == pytest.approx(4e-3, abs=5e-4)
    # 6 ms away lies the other break, which begins after 2; and what comes later feels the first one
    assert np.isnan([felt[end] for end in ("rope-2.start", "rope-2.end", "rope-3.start")]).all()


def test_a_joint_that_everything_leaves(tmp_path):
    body = LATER["fixed end"][0].replace("end = { fixed = [105, 0, 0] }", 'end = "bob"')
    with pytest.raises(SceneError, match='end at body "bob" that does not break'):
        run_text(tmp_path, body + '\n[bodies.bob]\nmass = "5 kg"\n')


@pytest.mark.slow
def test_two_lines_that_break_away_from_a_body_begin_each_by_itself(tmp_path):
    places = {"a": (-10.1, 0, 0), "b": (10.1, 0, 0), "c": (10.1, 0, 0)}
    lines = "".join(
        line_text(name, "m", 10, 4, 1, fixed(*place), '"bob"') for name, place in places.items()
    )
    ran = run_text(
        tmp_path,
        f"""
[materials.m]
law = "linear"
EA = "1 MN"
[bodies.bob]
mass = "1 t"
{lines}
[events]
early = {{ breaks = "a.end", start = "10 ms", time = "2 ms" }}
late = {{ breaks = "b.end", start = "30 ms", time = "2 ms" }}
[output]
duration = "40 ms"
every = "2 ms"
quantities = ["position"]
[solver]
waves = "plain"
""",
    )
    found = ran.outcomes[0].recoils
    assert found["a.end"]["break_start"] == 0.01
    assert found["b.end"]["break_start"] == 0.03


PLACE = "{ fixed = [10.5, 0, 0] }"
FORCE = '{ held = { pretension = "50 kN", direction = [1, 0, 0] } }'
# lines of 10 m, stretched by 5 %, that meet at x = 10.5 m; waves of 1000 m/s, EA = 1 MN
MEET = """
[materials.m]
law = "linear"
EA = "1 MN"
[bodies.ship]
position = [10.5, 0, 0]
points = {{ post = [0, 0, 0] }}
motion = {{ surge = {{ amplitude = "1 m", period = "1 s" }} }}
[lines.first]
material = "m"
length = 10
segments = 10
mass = 1
start = {{ fixed = [0, 0, 0] }}
end = {}
[lines.second]
material = "m"
length = 10
segments = 10
mass = 1
start = {}
end = {{ fixed = [21, 0, 0] }}
[events.early]
breaks = "{}"
start = "2 ms"
time = "1 ms"
[output]
duration = "7 ms"
every = "1 ms"
[solver]
waves = "plain"
"""
SHIP = '"ship.post"'


@pytest.mark.parametrize(
    ("end", "start", "alone"),
    [
        ('"second.start"', PLACE, True),
        (PLACE, '"first.end"', True),
        ('{ joined = "second.start", at = [10.5, 0, 0] }', PLACE, True),
        (SHIP, '"first.end"', True),
        (FORCE, '"first.end"', True),
        ('"second.start"', '"first.end"', False),
    ],
    ids=["place", "its own place", "at a place", "ship", "force", "each other"],
)
def test_what_something_else_holds_does_not_recoil(tmp_path, end, start, alone):
    for breaks, other in (("first.end", "second.start"), ("second.start", "first.end")):
        scene = scene_of(tmp_path, MEET.format(end, start, breaks))
        assert set(recoil_names(make_layout(scene))) == {breaks} | (set() if alone else {other})


@pytest.mark.slow  # the same of a body is among the quick ones
def test_lines_break_away_from_a_place_each_by_itself(tmp_path):
    text = MEET.format('"second.start"', PLACE, "first.end")
    third = text[text.index("[lines.second]") : text.index("[events")]
    third = third.replace("second", "third").replace("21", "31.5").replace(PLACE, '"second.end"')
    more = """[events.early_too]
breaks = "second.end"
start = "2 ms"
time = "1 ms"
[events.late]
breaks = "third.start"
start = "4 ms"
time = "1 ms"
"""
    ran = run_text(tmp_path, text + third + more)
    found = ran.outcomes[0].recoils
    begins = {"first.end": 2e-3, "second.end": 2e-3, "third.start": 4e-3}
    assert {end: numbers["break_start"] for end, numbers in found.items()} == begins
    # what the place still holds is as it was
    np.testing.assert_allclose(ran["second.tension"][:, :3, 0], 50e3, rtol=1e-9)
    for line, start in (("first", 2e-3), ("second", 2e-3), ("third", 4e-3)):
        # the wall pulls with 50 kN until the front is there, what breaks with half of it on average
        v = ran[f"{line}.velocity"][0, -1, :, 0]
        momentum = abs(v.sum() - 0.5 * (v[0] + v[-1]))
        assert momentum == pytest.approx(50e3 * (6.5e-3 - start), rel=0.02), line


class TestLoadedBeforeItBreaks:
    # pulled from 1 kN to 9 kN by a tug: 0.8 m in 1 s, waves of 1000 m/s along 100 m
    PULLED = 'end = { motion = { position = [100.1, 0, 0], velocity = [1, 0, 0], ramp = "0.4 s" } }'
    CHANGES = ("events.break.start=1 s", "events.break.time=20 ms", "output.duration=1.15 s")

    @pytest.mark.slow
    def test_the_break_is_felt_by_what_the_line_carries_then(self, tmp_path):
        held = 'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }'
        assert held in HOOKE
        ran = run_text(tmp_path, HOOKE.replace(held, self.PULLED), *self.CHANGES)
        found = ran.outcomes[0].recoils["rope.end"]
        assert found["static_tension"] == pytest.approx(1e3, rel=1e-9)
        # the front takes 100 ms; half a per cent has decayed, doubled at the wall, after 0.9 ms
        assert found["front_arrival"] == pytest.approx(0.1009, rel=0.03)
        # T / sqrt(EA m) of what the wall sent 100 ms before the last time, where nothing moves
        sent = ran["tension"][0, np.searchsorted(ran.time, 1.05 - 1e-9), 0]
        assert found["peak_end_speed"] == pytest.approx(sent / 1e3, rel=0.005)
        # no exact wave is claimed of a line that moves
        assert np.isnan([found[f"exact_{name}"] for name in EXACT]).all()

    def test_the_exact_wave_is_that_of_a_line_at_rest_however_late_it_breaks(self, tmp_path):
        ran = run_text(tmp_path, HOOKE, "events.break.start=10 ms", "output.duration=20 ms")
        assert ran.outcomes[0].recoils["rope.end"]["exact_peak_end_speed"] == pytest.approx(50.0)
