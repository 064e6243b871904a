"""What is compiled: absent physics is absent, and a changed number finds its program again."""

import os
import re
from contextlib import contextmanager
from functools import cache, partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import HOOKE, ROPE, scene_of, study_of
from jax import monitoring

from lumpedcable.exact import release_wave
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.numbers import number
from lumpedcable.solve.plan import Numbers
from lumpedcable.study import compiled, known_waves
from lumpedcable.study.compiled import advance_batch, begin_batch, prepare_batch
from lumpedcable.study.plan import plan_of, structure_of
from lumpedcable.study.run import run_study

WATER = '[water]\ndensity = "1025 kg/m3"\n'
# fields only, so that the energy account of a term does not hide the cost of the term
FIELDS = 'every = "1 ms"\nquantities = ["position", "velocity"]\n'
BARE = ROPE.replace('every = "1 ms"\n', FIELDS)
WET = WATER + BARE.replace(
    'mass = "2.238 kg/m"\n',
    'mass = "2.238 kg/m"\ndiameter = "50 mm"\ndrag = { normal = 1.5, tangential = 0.01 }\n',
)
PLANAR = 'gravity = "9.81 m/s2"\n' + BARE
BENT = PLANAR.replace('mass = "2.238', 'bending = { EI = "10 N m2" }\nmass = "2.238')
DAMPED = BARE.replace("tension_only = false", 'tension_only = false\ndamping = "1 kN s"')
PLAIN = BARE + '\n[solver]\nwaves = "plain"\n'


def program(folder, text):
    """The advance program of a scene, lowered but not run; of what it takes, the shapes alone."""
    scene = scene_of(folder, text)
    structure = structure_of(scene)
    coordinates = coordinates_of([scene])
    shared = {key: number(value) for key, value in scene.numbers().items()}
    swept = {"output.duration": jnp.asarray([shared.pop("output.duration")])}
    axes, origin = coordinates.axes, coordinates.origin
    ready = prepare_batch.eval_shape(structure, "float64", axes, origin, shared, swept)
    plan = plan_of(scene, structure.layout)
    numbers = Numbers(number(1e-3), jnp.asarray(20), number(1e-6), number(1e-8))
    state, _ = begin_batch.eval_shape(ready.packed, plan, numbers)
    return advance_batch.lower(ready.packed, plan, numbers, state, jnp.asarray(0), jnp.asarray(16))


@cache
def operations_of(folder, text):
    """Floating-point operations that XLA counts in one pass through the program's loops.

    Counted before fusion, which may compute a value twice to save a trip to memory; but on a GPU, where
    nothing is counted before.
    """
    lowered = program(folder, text)
    analysis = lowered.cost_analysis() or lowered.compile().cost_analysis()
    return analysis["flops"] + analysis.get("transcendentals", 0.0)


@pytest.fixture(scope="module")
def operations(tmp_path_factory):
    """`operations_of` a scene text, each of which is lowered once."""
    return partial(operations_of, tmp_path_factory.mktemp("programs"))


@pytest.mark.parametrize("more", [WET, PLANAR, DAMPED], ids=["drag", "second dimension", "damping"])
def test_what_a_scene_names_is_what_is_computed(operations, more):
    assert operations(BARE) < operations(more)


def test_bending_costs_only_where_it_is(operations):
    assert operations(PLANAR) < operations(BENT)


def test_waves_cost_only_where_they_are(operations):
    assert operations(PLAIN) < operations(BARE)


def test_energy_costs_only_where_it_is_asked_for(operations):
    assert operations(BARE) < operations(ROPE)


def test_a_third_dimension_costs_only_where_it_is(operations):
    bent = PLANAR.replace("direction = [1, 0, 0]", "direction = [1, 1, 0]")
    moved = PLANAR.replace("start = { fixed = [0, 0, 0] }", "start = { fixed = [5, 7, 9] }")
    assert operations(moved) == operations(PLANAR)
    # a direction out of the axes is still a plane, once turned; only the start adds a rotation
    assert operations(bent) == pytest.approx(operations(PLANAR), rel=1e-3)


def test_water_that_touches_nothing_is_not_there(operations):
    # density alone, without gravity, drag or added mass, acts on nothing
    assert operations(WATER + BARE) == operations(BARE)


def test_a_breaking_strength_is_in_no_program(tmp_path):
    strong = ROPE.replace("p1 =", "breaking_strength = '300 kN'\np1 =")
    assert scene_of(tmp_path, strong).materials["nylon"].breaking_strength == 300e3
    assert program(tmp_path, strong).as_text() == program(tmp_path, ROPE).as_text()


def test_a_straight_line_needs_no_norms(tmp_path):
    # in one dimension a strain has a sign; in two it takes the root of a square
    straight = program(tmp_path, PLAIN).as_text().count("stablehlo.sqrt")
    planar = program(tmp_path, PLAIN.replace(BARE, PLANAR)).as_text().count("stablehlo.sqrt")
    assert straight < planar


CHANGES = [
    "pretension=90 kN",
    "rope.length=45 m",
    "nylon.p1=280 kN",
    "mass=3 kg/m",
    "break.time=7 ms",
    "break.start=3 ms",
    "courant=0.5",
    "output.every=0.5 ms",
    "output.duration=35 ms",
    "rope.start.fixed=[1, 0, 0]",
]


def traces():
    """How often each program has been traced so far."""
    return {
        name: getattr(compiled, name)._cache_size()
        for name in ("prepare_batch", "begin_batch", "advance_batch")
    }


def test_another_number_needs_no_other_program(tmp_path):
    run_study(study_of(tmp_path, ROPE), tmp_path / "first.h5")
    before = traces()
    for change in CHANGES:
        run_study(study_of(tmp_path, ROPE, change), tmp_path / "next.h5")
    assert traces() == before


def test_another_structure_needs_another_program(tmp_path):
    run_study(study_of(tmp_path, ROPE), tmp_path / "first.h5")
    before = traces()
    run_study(study_of(tmp_path, ROPE, "rope.segments=31"), tmp_path / "next.h5")
    after = traces()
    assert all(after[name] == before[name] + 1 for name in before)


@contextmanager
def compilations():
    """The programs that are compiled, or fetched from the cache of them, meanwhile."""
    seen = []

    def hear(event, duration, **_):
        if event.endswith("/backend_compile_duration"):
            seen.append(duration)

    monitoring.register_event_duration_secs_listener(hear)
    try:
        yield seen
    finally:
        monitoring.unregister_event_duration_listener(hear)


@pytest.mark.parametrize("only", [True, False])
def test_the_numbers_of_a_run_with_another_table_need_no_other_program(tmp_path, only):
    # tables of Hooke's law, T = EA e: released at T0 its end has c T0 / EA = T0 / sqrt(EA m)
    def law_of(EA):
        strain = [0.0, 0.01, 0.02, 0.05, 0.1, 0.3]
        rows = f"strain = {strain}\ntension = {[EA * e for e in strain]}\n"
        text = HOOKE.replace('law = "linear"\nEA = "1 MN"\n', f'law = "table"\n{rows}{push}')
        return known_waves.curve_of(scene_of(tmp_path, text), "rope")

    push = f"tension_only = {'true' if only else 'false'}\n"
    counts = []
    for EA in (1.0e6, 1.5e6, 2.0e6, 2.5e6):
        with compilations() as seen:
            law = law_of(EA)
            found = law(np.array([-0.01, 0.015, 0.04, 0.25]))
            wave = release_wave(law, 1.0, tension0=5.0e4)
        counts.append(len(seen))
        pushed = 0.0 if only else -0.01
        np.testing.assert_allclose(found, EA * np.array([pushed, 0.015, 0.04, 0.25]), rtol=1e-12)
        assert wave.end_speed == pytest.approx(5.0e4 / EA**0.5, rel=1e-6)
    # a wave may ask for another number of strains once, not for every law
    assert counts[2:] == [0, 0]


def test_static_tensions_of_swept_tables_need_one_program(tmp_path):
    rows = "strain = [0.0, 0.1, 0.3]\ntension = [0.0, 1.0e5, 3.0e5]\n"
    text = HOOKE.replace('law = "linear"\nEA = "1 MN"\n', f'law = "table"\n{rows}')
    text += '[sweep]\n"materials.hooke.damping" = [0, 1, 2, 3, 4, 5]\n'
    study = study_of(tmp_path, text)
    assert "materials.hooke.damping" in study.runs.moved
    structure = SimpleNamespace(scene=study.runs[0])

    def tensions(*runs):
        strain = 0.01 * (1.0 + np.array(runs))
        part = SimpleNamespace(runs=np.array(runs), structure=structure)
        return known_waves.tensions_of(study, part, "rope", strain)

    np.testing.assert_allclose(tensions(0), [1.0e4], rtol=1e-12)
    with compilations() as seen:
        found = tensions(0, 1, 2, 3, 4, 5)
    np.testing.assert_allclose(found, 1.0e4 * np.arange(1, 7), rtol=1e-12)
    assert seen == []
    with compilations() as seen:  # which hears of a program that is not known
        jax.jit(lambda x: 3.0 * x)(1.0)
    assert seen


def test_the_energy_account_does_not_change_the_motion(tmp_path):
    scenes = [scene_of(tmp_path, text) for text in (BARE, ROPE)]
    ends = []
    for text in (BARE, ROPE):
        target = tmp_path / "out.h5"
        outcome = run_study(study_of(tmp_path, text), target)[0]
        ends.append(outcome.recoils["rope.end"]["end_displacement"])
    assert scenes[0].output.quantities != scenes[1].output.quantities
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)


def test_programs_are_kept_for_the_next_process():
    assert jax.config.jax_compilation_cache_dir
    assert jax.config.jax_persistent_cache_min_compile_time_secs <= 0.1


@pytest.mark.skipif(not compiled.ON_CPU, reason="only the CPU's compiler has the choice")
def test_the_loop_over_the_steps_is_one_function(tmp_path):
    """Not a list of small ones, each called for itself at every step."""
    text = program(tmp_path, BARE).compile().as_text()
    entry = text[text.index("ENTRY") :]
    assert "xla_cpu_small_call" in entry
    assert " while(" not in entry


AFLOAT = """
gravity = 9.81
[water]
density = 1000
surface = 0
[materials.wire]
law = "linear"
EA = "1 MN"
[bodies.box]
mass = 400
volume = 1
size = [1, 1, 1]
position = [0, 0, 0]
drag = [1, 1, 1]
added_mass = [0.5, 0.5, 0.5]
[lines.wire]
material = "wire"
length = "5 m"
segments = 4
mass = 1
diameter = "10 mm"
start = { fixed = [0, 0, -5] }
end = "box"
[output]
duration = "1 s"
every = "50 ms"
"""


@pytest.mark.slow
@pytest.mark.skipif(not compiled.ON_CPU, reason="only the CPU's compiler has the choice")
def test_with_bodies_the_steps_alone_are_one_function(tmp_path):
    """A step four times as fast, and no long function of the loop over outputs around them."""
    text = program(tmp_path, AFLOAT).compile().as_text()
    calls = [line for line in text.splitlines() if "xla_cpu_small_call" in line]
    assert len(calls) == 1
    sorts = re.findall(r"= (\S+) sort\(", text)
    assert [kind.partition("[")[0] for kind in sorts] == ["s64"]
    assert " while(" in text[text.index("ENTRY") :]  # that over the outputs


@pytest.mark.skipif(not compiled.ON_CPU, reason="elsewhere calls are left as they are")
def test_a_call_is_one_function(tmp_path):
    # beside it, room is made for what it returns; of more than eight parts XLA asks threads to help
    text = program(tmp_path, ROPE).compile().as_text()
    entry = text[text.index("ENTRY") :].splitlines()
    called = re.compile(r"\b(fusion|copy|call|while|conditional|custom-call)\(")
    parts = [match[1] for line in entry if (match := called.search(line))]
    assert parts.count("call") == 1
    assert len(parts) <= 8


def test_options_of_the_user_are_kept(monkeypatch):
    name, value = compiled.WHOLE_LOOPS
    monkeypatch.setenv("XLA_FLAGS", "--xla_dump_to=there")
    compiled.configure()
    compiled.configure()
    assert os.environ["XLA_FLAGS"] == f"--xla_dump_to=there {name}={value}"
    monkeypatch.setenv("XLA_FLAGS", f"{name}=mine=1")
    compiled.configure()
    assert os.environ["XLA_FLAGS"] == f"{name}=mine=1"


@pytest.mark.skipif(not compiled.ON_CPU, reason="these are options of the CPU's compiler")
def test_options_that_the_compiler_does_not_know_are_not_given():
    known = {"xla_backend_optimization_level": 0}
    assert compiled.understood(known) == known
    assert compiled.understood(known | {"xla_cpu_no_such_option": True}) is None
