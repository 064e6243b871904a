"""Records of different lengths and samplings in one fit: each is run to its own end, and no further."""

import jax
import numpy as np
import pytest
from engine_runs import nylon_rope, run_text
from fit_files import fit_of

from lumpedcable.fitting import minimise
from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.residual import penalised, predict
from lumpedcable.fitting.ropes import fit_ropes
from lumpedcable.fitting.transforms import to_unbounded
from lumpedcable.status import Status

# of the pull in kN and the length in ms: with the second pull the line turns over at 186 ms, long before
# the other record ends
LINE = nylon_rope(6, "100 ms") + '[solver]\nstep = "1 ms"\n'
RECORDS = {"long": (45, 400), "short": (400, 100)}
EVERY = 4  # ms
RECORD = """
[experiments.{name}]
file = "{name}.csv"
set = {{ pretension = "{pull} kN" }}
time = {{ column = "t", unit = "ms" }}
observe = [
    {{ quantity = "velocity", at = "rope.end", component = "x", column = "v", noise = "1 m/s" }},
]
"""
FREE = """scene = "scene.toml"
[free]
"materials.nylon.p2" = { start = 10.0 }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder with the data of both, as the engine gives them, and what they are (m/s)."""
    folder = tmp_path_factory.mktemp("uneven")
    data = {}
    for name, (pull, last) in RECORDS.items():
        ran = run_text(folder, LINE, f"pretension={pull} kN", f"duration={last} ms")
        assert list(ran.statuses) == ["OK"]
        data[name] = ran["velocity"][0, EVERY::EVERY, -1, 0]
        rows = [f"{t * EVERY},{v!r}" for t, v in enumerate(data[name].tolist(), start=1)]
        (folder / f"{name}.csv").write_text("t,v\n" + "\n".join(rows) + "\n")
    return folder, data


def problem_of(folder, *names, more=""):
    text = FREE + "".join(RECORD.format(name=n, pull=RECORDS[n][0]) for n in names)
    return fit_of(folder, text + more, LINE).problem


@pytest.mark.slow
def test_a_record_is_not_run_beyond_its_own_data(folder):
    folder, data = folder
    spec, arrays = arrays_of(problem_of(folder, *RECORDS))
    found = jax.jit(predict, static_argnums=0)(spec, arrays, np.array([10.2]))
    assert [Status(int(s)) for s in found.status[0]] == [Status.OK, Status.OK]
    for model, told in zip(found.groups[0], data.values(), strict=True):
        assert model[0, : told.size] == pytest.approx(told, abs=1e-6 * np.max(np.abs(told)))


@pytest.mark.slow
def test_records_of_other_spacings_are_stepped_as_each_would_be_alone(tmp_path):
    ran = run_text(tmp_path, LINE, "pretension=45 kN")
    for name, every in (("fine", 4), ("coarse", 20)):
        speeds = ran["velocity"][0, every::every, -1, 0].tolist()
        rows = [f"{t * every},{v!r}" for t, v in enumerate(speeds, start=1)]
        (tmp_path / f"{name}.csv").write_text("t,v\n" + "\n".join(rows) + "\n")
    text = FREE + "".join(RECORD.format(name=name, pull=45) for name in ("fine", "coarse"))
    spec, arrays = arrays_of(fit_of(tmp_path, text, LINE).problem)
    found = jax.jit(predict, static_argnums=0)(spec, arrays, np.array([10.2]))
    speeds = ran["velocity"][0, :, -1, 0]
    # each at the steps of 1 ms that the scene asks for, which are those of the run
    for (model,), every in zip(found.groups, (4, 20), strict=True):
        assert model[0] == pytest.approx(speeds[every::every], abs=1e-9 * np.max(np.abs(speeds)))


@pytest.mark.slow
def test_a_way_back_through_records_of_different_lengths(folder, monkeypatch):
    folder, _ = folder

    problem = problem_of(folder, *RECORDS)
    spec, arrays = arrays_of(problem, [EVERY])
    z = to_unbounded(arrays.transform, np.array([p.start for p in problem.parameters]))
    squared = jax.jit(penalised, static_argnums=0)

    def half(z):
        return 0.5 * float(np.sum(np.asarray(squared(spec, arrays, z)[0]) ** 2))

    h = 1e-5
    difference = (half(z + h) - half(z - h)) / (2.0 * h)
    monkeypatch.setattr(minimise, "REVERSE_FROM", 1)
    value, slope = jax.jit(minimise.value_and_gradient, static_argnums=0)(spec, arrays, z)
    assert float(value) == pytest.approx(half(z), rel=1e-9)
    assert float(slope[0]) == pytest.approx(difference, rel=1e-6)


@pytest.mark.slow
def test_ropes_whose_records_differ_in_length(tmp_path):
    names = {"one": 4, "two": 20}
    ran = run_text(tmp_path, LINE, "pretension=400 kN")
    for name, every in names.items():
        speeds = ran["velocity"][0, every::every, -1, 0].tolist()
        rows = [f"{t * every},{v!r}" for t, v in enumerate(speeds, start=1)]
        (tmp_path / f"{name}.csv").write_text("t,v\n" + "\n".join(rows) + "\n")
    text = 'ropes = ["one", "two"]\n' + FREE + RECORD.format(name="{rope}", pull=400)
    text = text.replace("[experiments.{rope}]", "[experiments.pull]")
    for fitted in fit_ropes(fit_of(tmp_path, text, LINE).ropes).values():
        assert fitted.failures == ()
        assert sum(start.failed for start in fitted.starts) == 0
        assert fitted.values == pytest.approx([10.2], rel=1e-6)
