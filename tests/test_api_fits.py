"""Fits and sensitivities from Python: what the commands write, as objects."""

import json

import numpy as np
import pytest
from fit_files import BENCH, NAMES, SCENE, TRUTH, bench_of, free, write_bench
from nylon_line import tension

import lumpedcable as lc
from lumpedcable.scene import load_study

CUBIC = """noise = "1 %"
[choices.cubic]
set = { "materials.nylon" = { law = "polynomial", coefficients = [1e5, 1e5, 1e5] } }
free = { "materials.nylon.coefficients" = {} }
"""


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    bench_of(folder, 1.2 * TRUTH, noise=0.01, more=CUBIC)
    return lc.fit(folder / "fit.toml")


def test_a_fit_has_its_numbers_with_their_intervals(bench, tmp_path):
    assert bench.converged
    assert list(bench.numbers) == NAMES
    p2 = bench[NAMES[1]]
    assert p2.low < TRUTH[1] < p2.high
    assert (p2.key, p2.experiment, p2.unit) == (NAMES[1], "", "")
    assert p2.start == pytest.approx(1.2 * TRUTH[1])
    # the covariance is that of the deviations, and its root the standard deviation
    assert np.sqrt(np.diag(bench.covariance)) == pytest.approx(
        [n.std for n in bench.numbers.values()], rel=1e-9
    )
    scale = np.sqrt(np.outer(np.diag(bench.covariance), np.diag(bench.covariance)))
    assert bench.correlation * scale == pytest.approx(bench.covariance, rel=1e-6)
    # the law that made the data is the better one
    assert bench.aic < bench.choices["cubic"].aic
    assert bench.bic < bench.choices["cubic"].bic
    assert any("The data do not tell nylon p5" in remark for remark in bench.remarks)
    # what the data hardly tell has the interval of its profile, as the command prints it
    (made,) = [path for path in bench.save(tmp_path) if path.suffix == ".json"]
    told = json.loads(made.read_text())
    assert [bench[NAMES[4]].low, bench[NAMES[4]].high] == told["profiles"][0]["interval"]
    assert told["parameters"][0]["value"] == bench[NAMES[0]].value
    assert set(told["choices"]) == {"cubic"}
    assert repr(bench).startswith("Fit(materials.nylon.p1 = ")


def test_a_fit_is_drawn_and_its_scene_is_good(bench, tmp_path, capsys):
    figures = bench.plot()
    assert list(figures) == ["data", "residuals", "correlations", "laws", "profiles"]
    assert figures._repr_html_().count("<img") == 5
    assert {path.stem for path in bench.plot(tmp_path, ["svg"])} == set(figures)
    made = bench.save(tmp_path)
    (scene,) = [path for path in made if path.suffix == ".toml" and path.parent == tmp_path]
    found = load_study(scene).scene.materials["nylon"].p2
    assert found == pytest.approx(bench[NAMES[1]].value, rel=1e-9)
    bench.report()
    assert "nylon p1" in capsys.readouterr().out


def test_ropes_are_fits_by_name(tmp_path):
    strain = np.linspace(0.005, 0.32, 30)
    for name, factor in (("a", 1.0), ("b", 1.1)):
        write_bench(tmp_path, strain, factor * tension(strain), f"{name}.csv")
    (tmp_path / "scene.toml").write_text(SCENE)
    text = 'scene = "scene.toml"\nropes = "*"\n' + free([2e5, 2e5], [NAMES[0], NAMES[3]])
    file = tmp_path / "fit.toml"
    file.write_text(text + BENCH.replace("bench.csv", "{rope}.csv"))
    found = lc.fit_ropes(file)
    assert list(found) == ["a", "b"]
    for key in (NAMES[0], NAMES[3]):
        # p5 stays as it was for the rope that is stronger by a tenth: 4 N of 480 kN
        assert found["b"][key].value / found["a"][key].value == pytest.approx(1.1, rel=1e-4)
    with pytest.raises(ValueError, match="expected one rope, found 2: use fit_ropes"):
        lc.fit(file)


def test_mistakes_in_a_fit_are_told(tmp_path):
    with pytest.raises(lc.SceneError, match="expected a file, found none"):
        lc.fit(tmp_path / "none.toml")
    bench_of(tmp_path, TRUTH)
    (tmp_path / "bench.csv").write_text("strain (%),load\n1,2\n2,nan\n")
    with pytest.raises(lc.SceneError, match=r'found "nan" in bench\.csv:3'):
        lc.fit(tmp_path / "fit.toml")


SPRING = """
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = "10 m"
segments = 2
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = ["10.1 m", 0, 0] }
[output]
duration = "2 ms"
every = "1 ms"
"""


@pytest.mark.slow
def test_what_a_result_depends_on(tmp_path):
    # T = EA (s/L - 1): dT/dEA = e, dT/ds = EA/L, dT/dL = -EA s/L^2, none by the mass; at rest
    (tmp_path / "scene.toml").write_text(SPRING)
    found = lc.sensitivity(tmp_path / "scene.toml", "last tension at rope.start", EA="2 MN")
    assert (found.value, found.unit, found.status) == (pytest.approx(2e4), "N", "ok")
    assert found.result == "last tension at rope.start"
    wanted = {
        "materials.hooke.EA": 0.01, "lines.rope.end.fixed.0": 2e5, "lines.rope.start.fixed.0": -2e5,
        "lines.rope.length": -2.02e5, "lines.rope.mass": 0.0,
    }  # fmt: skip
    for key, slope in wanted.items():
        assert found[key].derivative == pytest.approx(slope, rel=1e-9, abs=1e-9), key
    assert found["materials.hooke.EA"].share == pytest.approx(1.0)
    assert [abs(n.share) for n in found.numbers.values()] == sorted(
        [abs(n.share) for n in found.numbers.values()], reverse=True
    )
    assert list(found.plot()) == ["sensitivity"]
    made = found.save(tmp_path) + found.plot(tmp_path)
    assert [path.name for path in made] == ["sensitivity.json", "sensitivity.png"]
    with pytest.raises(ValueError, match="run: expected one from 0 to 0, found 1"):
        lc.sensitivity(tmp_path / "scene.toml", run=1)
    with pytest.raises(ValueError, match='expected a line of the scene, found "roep"'):
        lc.sensitivity(tmp_path / "scene.toml", "max tension at roep.start")
