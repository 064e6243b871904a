"""Breaks along a line whose place is a number: one program for all places, the same answers."""

from dataclasses import replace

import numpy as np
import pytest
from engine_runs import HOOKE, NYLON, ROPE, run_text, study_of

from lumpedcable.model import cuts
from lumpedcable.model.cuts import LEAST
from lumpedcable.model.layout import make_layout
from lumpedcable.results import open_result
from lumpedcable.study import compiled
from lumpedcable.study.laying import lay_out

BETWEEN_WALLS = HOOKE.replace(
    'end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }',
    "end = { fixed = [105, 0, 0] }",
).replace('breaks = "rope.end"', 'breaks = "rope@40 m"')
# weight, drag, added mass, damping, a moved end and a late break, all in a plane
PLANE = """
gravity = 9.81
[water]
density = 1025
[lines.rope]
material = "nylon"
length = "60 m"
segments = 24
mass = "2.238 kg/m"
diameter = "50 mm"
drag = { normal = 1.5, tangential = 0.01 }
added_mass = { normal = 1.0 }
start = { fixed = [0, 0, 0] }
end = { motion = { position = [66, 0, 0], velocity = [2, 0, 1] } }
[events.break]
breaks = "rope"
place = "22 m"
time = "4 ms"
start = "3.3 ms"
[measures]
wall = { tension = "rope.start" }
beside = { tension = "rope@21 m" }
[output]
duration = "30 ms"
every = "1 ms"
"""
PLANE += NYLON.replace("tension_only = false", 'tension_only = true\ndamping = "1 kN s"')
# in space: a bed, a current across
SPACE = PLANE.replace(
    "density = 1025\n",
    "density = 1025\ncurrent = { velocity = [0, 1, 0] }\n"
    '[seabed]\nheight = "-1.2 m"\nstiffness = "20 kPa"\ndamping = "500 Pa s"\n',
)
PLACES = "events.break.place=[15 m, 22 m, 40 m]"


@pytest.fixture
def no_seams(monkeypatch):
    """Call it, and lines that break along their length are two lines joined from then on."""
    return lambda: monkeypatch.setattr(cuts, "has_seam", lambda scene, name: False)


def row(ran, run):
    """The one run of a file as if it were alone, without what other runs have more of."""

    def own(values):
        alone = values[run : run + 1]
        return alone[..., ~np.all(np.isnan(alone), axis=(0, 1))] if alone.ndim == 3 else alone

    def nodes(values):
        return values[run : run + 1][:, :, ~np.all(np.isnan(values[run]), axis=(0, 2))]

    lines = {
        name: {k: nodes(x) if x.ndim == 4 else own(x) for k, x in line.items()}
        for name, line in ran.lines.items()
    }
    energy = {term: values[run : run + 1] for term, values in ran.energy.items()}
    return replace(ran, outcomes=[ran.outcomes[run]], lines=lines, energy=energy)


def close(mine, joined, share):
    """Fields, energies and numbers of runs are equal to a share of their largest values."""
    assert mine.statuses == joined.statuses == ["OK"]
    assert set(mine.lines) == set(joined.lines) == {"rope-1", "rope-2"}
    for name, line in joined.lines.items():
        for quantity, values in line.items():
            most = np.nanmax(np.abs(values))
            np.testing.assert_allclose(
                mine.lines[name][quantity], values, rtol=0, atol=share * most, equal_nan=True
            )
    for term, values in joined.energy.items():
        most = np.max(np.abs(joined.energy["strain"]))
        np.testing.assert_allclose(mine.energy[term], values, rtol=0, atol=share * most)
    for a, b in zip(mine.outcomes, joined.outcomes, strict=True):
        assert a.recoils.keys() == b.recoils.keys() == {"rope-1.end", "rope-2.start"}
        for end, numbers in b.recoils.items():
            assert a.recoils[end] == pytest.approx(numbers, rel=1e3 * share, nan_ok=True)
        assert a.measures == pytest.approx(b.measures, rel=1e2 * share)


@pytest.mark.parametrize(
    ("text", "changes", "share"),
    [
        pytest.param(PLANE, (), 1e-9, id="plane", marks=pytest.mark.slow),
        # at rest a line that is whole has one direction at a node, two that are joined have two, so that
        # a current across lets them hang a little differently; the limiter makes more of that
        pytest.param(SPACE, (), 2e-5, id="space", marks=pytest.mark.slow),
        pytest.param(
            PLANE, ('solver.method="rk4"', 'solver.waves="viscous"'), 1e-9, id="rk4",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            PLANE, ('solver.method="tsit5"', 'solver.waves="plain"', "solver.atol=1e-9"), 1e-6,
            id="tsit5", marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_a_line_with_a_seam_is_two_lines_that_are_joined(tmp_path, no_seams, text, changes, share):
    mine = run_text(tmp_path, text, *changes)
    no_seams()
    joined = run_text(tmp_path, text, *changes)
    close(mine, joined, share)
    # something happened: both ends recoil, and the wall has felt it
    assert all(
        numbers["peak_end_speed"] > 5.0 for o in mine.outcomes for numbers in o.recoils.values()
    )


@pytest.mark.slow
def test_another_place_needs_no_other_program(tmp_path):
    def traces():
        names = ("prepare_batch", "begin_batch", "advance_batch")
        return {name: getattr(compiled, name)._cache_size() for name in names}

    # the speed of 50 m/s and the time to the wall at 1000 m/s are those of either part
    first = run_text(tmp_path, BETWEEN_WALLS, "output.duration=30 ms", "break.time=4 ms")
    before = traces()
    other = run_text(
        tmp_path,
        BETWEEN_WALLS,
        "output.duration=30 ms",
        "break.time=4 ms",
        "break.breaks=rope@72 m",
    )
    assert traces() == before
    for ran, place in ((first, 40.0), (other, 72.0)):
        assert ran.places["rope-1"][-1] == pytest.approx(place, rel=1e-12)
        for name, node, length, sign in (
            ("rope-1", -1, place, -1.0),
            ("rope-2", 0, 100.0 - place, 1.0),
        ):
            speed = sign * ran[f"{name}.velocity"][0, :, node, 0]
            steady = (ran.time > 8e-3) & (ran.time < 2e-3 * length)
            assert np.mean(speed[steady]) == pytest.approx(50.0, rel=5e-3)


def test_runs_of_all_places_are_one_structure(tmp_path):
    sweep = '[sweep]\n"events.break.place" = { from = "12.5 m", to = "47.5 m", count = 99 }\n'
    study = study_of(tmp_path, PLANE + sweep)
    laid = lay_out(study)
    assert len(laid.structures) == 1
    # 24 segments of 2.5 m: the longest part before the cut has 19, as has the longest after it
    assert laid.segments == {"rope-1": 19, "rope-2": 19}


def test_a_cut_near_an_end_is_structure(tmp_path):
    near = study_of(tmp_path, PLANE, "events.break.place=[2.5 m, 5 m, 12.5 m, 30 m, 55 m]")
    laid = lay_out(near)
    found = [laid.structures[k].layout for k in laid.which(np.arange(5))]
    assert [[piece.name for piece in own.pieces] for own in found] == [
        ["rope-1", "rope-2"], ["rope-1", "rope-2"], ["rope"], ["rope"], ["rope-1", "rope-2"],
    ]  # fmt: skip
    assert len(laid.structures) == 4
    assert laid.segments == {"rope-1": 22, "rope-2": 23}
    assert LEAST == 5


@pytest.mark.slow
def test_runs_of_different_places_stand_in_one_file(tmp_path):
    text = BETWEEN_WALLS.replace('"rope@40 m"', '"rope"\nplace = "40 m"')
    changes = ("break.place=[4 m, 30 m, 72 m]", "output.duration=20 ms", "break.time=4 ms")
    ran = run_text(tmp_path, text, *changes)
    assert ran.statuses == ["OK"] * 3
    with open_result(tmp_path / "result.h5") as found:
        lines = [found.line(name) for name in ("rope-1", "rope-2")]
        places = [[line.unstretched_position(run) for line in lines] for run in range(3)]
    for run, (place, nodes) in enumerate(((4.0, 3), (30.0, 16), (72.0, 37))):
        for part, (own, count) in enumerate(zip(places[run], (nodes, 52 - nodes), strict=True)):
            assert np.all(np.isfinite(own[:count]))
            assert np.all(np.isnan(own[count:]))
            assert own[count - 1] == pytest.approx((place, 100.0)[part], rel=1e-12)
            position, tension = (ran[f"rope-{part + 1}.{q}"][run] for q in ("position", "tension"))
            assert np.all(np.isfinite(position[:, :count]))
            assert np.all(np.isnan(position[:, count:]))
            assert np.all(np.isfinite(tension[:, : count - 1]))
            assert np.all(np.isnan(tension[:, count - 1 :]))
        # stretched by 5 % between the walls
        assert ran["rope-1.position"][run, 0, nodes - 1, 0] == pytest.approx(1.05 * place, rel=1e-9)


WHOLE = {
    "bending": ('diameter = "50 mm"', 'diameter = "50 mm"\nbending = { EI = 10 }'),
    "friction on the bed": (
        "[water]",
        '[seabed]\nheight = -50\nstiffness = "20 kPa"\nfriction = 0.4\n[water]',
    ),
    "uneven segments": ("segments = 24", "segments = 24\ngrading = 2"),
    "two breaks": ("[measures]", '[events.other]\nbreaks = "rope@50 m"\ntime = 0\n[measures]'),
    "an end that breaks too": (
        "[measures]",
        '[events.other]\nbreaks = "rope.end"\ntime = 0\n[measures]',
    ),
}


@pytest.mark.parametrize("name", WHOLE)
def test_what_reaches_across_a_cut_makes_it_structure(tmp_path, name):
    def names(text):
        scene = study_of(tmp_path, text).runs[0]
        return [piece.name for piece in make_layout(scene, seams=True).pieces]

    assert names(PLANE) == ["rope"]
    assert names(PLANE.replace(*WHOLE[name]))[:2] == ["rope-1", "rope-2"]


def test_a_line_that_breaks_at_its_end_has_no_seam(tmp_path):
    scene = study_of(tmp_path, ROPE).runs[0]
    assert make_layout(scene, seams=True) == make_layout(scene)
