"""Means and standard deviations of measures, and as numbers of a run that have derivatives."""

import jax
import numpy as np
import pytest
from engine_runs import study_of

from lumpedcable import response
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

PERIOD, HEIGHT = 8.0, 3.0
SCENE = f"""
[sea]
height = {HEIGHT}
period = {PERIOD}
components = 1
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = 10
segments = 2
mass = 1
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = [10.1, 0, 0], amplitude = [0.05, 0, 0], period = "{PERIOD} s" }} }}
[measures.gauge]
elevation = [3, 4]
[measures.late]
elevation = [0, 0]
after = "10 s"
[measures.place]
position = "rope.end"
component = "x"
extreme = "least"
[sweep]
"sea.height" = [{HEIGHT}, {2.0 * HEIGHT}]
[output]
duration = "15.9 s"
every = "0.1 s"
statistics = true
keep = "summaries"
"""


@pytest.mark.slow
def test_measures_have_means_and_deviations(tmp_path):
    target = tmp_path / "result.h5"
    run_study(study_of(tmp_path, SCENE), target)
    with open_result(target) as result:
        found = result.summary()["run"]
        told = {n: result.summary_attributes("run", n) for n in ("gauge_mean", "gauge_deviation")}
        assert list(result.measured) == ["gauge", "late", "place"]
    # 160 times in two periods: of a sine the mean is 0 and the deviation its amplitude over root 2
    deviation = np.array([1.0, 2.0]) * HEIGHT / 4.0
    np.testing.assert_allclose(found["gauge_mean"], 0.0, atol=1e-12)
    np.testing.assert_allclose(found["gauge_deviation"], deviation, rtol=1e-12)
    np.testing.assert_allclose(found["place_mean"], 10.1, rtol=1e-12)
    np.testing.assert_allclose(found["place_deviation"], 0.05 / np.sqrt(2.0), rtol=1e-9)
    np.testing.assert_allclose(found["place"], 10.05, atol=1e-9)
    # 60 times from 10 s on, of the same sine
    t = np.arange(100, 160) * 0.1
    both = np.array(found["late_mean"]), np.array(found["late_deviation"])
    wave = np.cos(2.0 * np.pi / PERIOD * t + phase_of(tmp_path))
    for k, amplitude in enumerate(deviation * np.sqrt(2.0)):
        assert both[0][k] == pytest.approx(amplitude * wave.mean(), rel=1e-9)
        assert both[1][k] == pytest.approx(amplitude * wave.std(), rel=1e-9)
    assert told["gauge_mean"]["units"] == told["gauge_deviation"]["units"] == "m"
    assert told["gauge_deviation"]["long_name"].startswith("standard deviation of the height of")


def phase_of(folder):
    """The one phase of the sea (rad), from the first two values of a gauge at the origin."""
    target = folder / "phase.h5"
    text = SCENE.replace('keep = "summaries"', "").replace("[3, 4]", "[0, 0]")
    run_study(study_of(folder, text), target)
    with open_result(target) as result:
        gauge = result.measures()["gauge"][0][0]
    amplitude, step = HEIGHT / 4.0 * np.sqrt(2.0), 2.0 * np.pi / PERIOD * 0.1
    first, second = gauge[:2] / amplitude
    return np.arctan2((first * np.cos(step) - second) / np.sin(step), first)


@pytest.mark.parametrize(
    ("of", "value", "slopes"),
    [
        ("std position at rope.end in x", 0.05 / np.sqrt(2.0), [1.0 / np.sqrt(2.0), 0.0]),
        pytest.param("mean position at rope.end in x", 10.1, [0.0, 1.0], marks=pytest.mark.slow),
        pytest.param("mean place", 10.1, [0.0, 1.0], marks=pytest.mark.slow),
        pytest.param("std gauge", HEIGHT / 4.0, [0.0, 0.0], marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_they_are_numbers_that_have_derivatives(tmp_path, of, value, slopes):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE[: SCENE.index("[sweep]")] + SCENE[SCENE.index("[output]") :])
    by = ["lines.rope.end.motion.amplitude.0", "lines.rope.end.motion.position.0"]
    number = response(path, by, of)
    found, gradient = jax.value_and_grad(number)(number.values)
    assert found == pytest.approx(value, rel=1e-9)
    np.testing.assert_allclose(gradient, slopes, atol=1e-8)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '[measures.place]\nposition = "rope.end"\ncomponent = "x"\nextreme = "least"',
            "[measures.gauge_mean]\nelevation = [0, 0]",
            'expected another name, found "gauge_mean", which is the mean of "gauge"',
        ),
        (
            'duration = "15.9 s"\nevery = "0.1 s"\n',
            "",
            "output.statistics: expected a duration where there are statistics, found none",
        ),
    ],
)
def test_what_statistics_do_not_go_with_is_told(tmp_path, old, new, words):
    assert old in SCENE
    (tmp_path / "scene.toml").write_text(SCENE.replace(old, new))
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "scene.toml")
    assert any(words in str(fault) for fault in caught.value.faults), caught.value.faults


def test_statistics_of_no_measures_are_told(tmp_path):
    text = SCENE.replace("statistics = true", "")
    text = text[: text.index("[measures.gauge]")] + text[text.index("[sweep]") :]
    text = text[: text.index("[sea]")] + text[text.index("[materials.hooke]") :]
    text = text.replace('"sea.height" = [3.0, 6.0]', '"lines.rope.mass" = [1, 2]')
    (tmp_path / "scene.toml").write_text(text + "statistics = true\n")
    with pytest.raises(SceneError, match="expected measures where there are statistics"):
        load_study(tmp_path / "scene.toml")
