"""What the live page answers depends on the numbers asked alone, and is numbers or words."""

import json

import numpy as np
import pytest
from command_line import ROOT

from lumpedcable.exact import STAGES, highline_from_tension, loaded_from_length
from lumpedcable.page.controls import FaultError
from lumpedcable.page.elastic import elastic_model
from lumpedcable.page.stages import stage_models
from lumpedcable.scene import load_study

CONFIGS = ROOT / "configs" / "highline"


def told(model, **values):
    answer = model.solve(values)
    json.dumps(answer, allow_nan=False)
    return {row["key"]: row["value"] for row in answer["numbers"]}


@pytest.fixture(scope="module")
def adjusted():
    edits = ["lines.highline.segments=16"]
    return elastic_model(load_study(CONFIGS / "adjustment.toml", edits))


@pytest.mark.slow
def test_a_winch_finds_the_taut_line_in_any_order(adjusted):
    """80 kN have a slack line too, of 4 km, that is near once the ends have been farther apart."""
    x, z = "lines.highline.end.fixed.0", "lines.highline.end.fixed.2"
    for span, drop, asked in (
        (83.94, 16.0, {x: 83.94}),
        (60.0, -0.53, {z: 0.53}),
        (87.79, 16.0, {x: 87.79}),
        (30.0, 16.0, {x: 30.0}),
        (60.0, 16.0, {}),
    ):
        exact = highline_from_tension(span, drop, 40.0, 80e3)
        found = told(adjusted, **asked)
        # stretch 1e-6, chords of 4 m under 80 kN: less
        assert found["highline/length"] == pytest.approx(float(exact.length), rel=1e-5)
        assert found["highline/start_tension"] == pytest.approx(80e3, rel=1e-8)


@pytest.mark.slow
def test_a_low_tension_too_has_its_taut_line(adjusted):
    exact = highline_from_tension(60.0, 16.0, 40.0, 3e3)
    told(adjusted, **{"lines.highline.end.fixed.0": 91.0})
    found = told(adjusted, **{"targets.winch.tension": 3e3})
    assert found["highline/length"] == pytest.approx(float(exact.length), rel=1e-3)


@pytest.mark.slow  # a quarter of a minute of compiling
def test_what_was_mistyped_is_forgotten():
    edits = ["lines.before.segments=16", "lines.after.segments=16"]
    model = elastic_model(load_study(CONFIGS / "delivery.toml", edits))
    first = told(model)
    # the straight lines beside 5 m of a line of 62.5 m: chords of 0.4 m and 3.5 m
    exact = loaded_from_length(60.0, 16.0, 40.0, 20e3, 5.0, 62.5)
    assert first["before/start_tension"] == pytest.approx(float(exact.tension_a), rel=2e-3)
    for value in (17250.0, 17.25, 500.0, -17.25):
        with pytest.raises(FaultError) if value > 0.0 else np.errstate():
            told(model, **{"lines.before.start.fixed.0": value})
        assert told(model) == first


def words_of(answer, values):
    """What is said where there is no answer; "" where there is one, of finite numbers."""
    try:
        json.dumps(answer(values), allow_nan=False)
    except FaultError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("stage", STAGES)
def test_absurd_numbers_of_a_stage_get_numbers_or_words(stage, capfd):
    model = next(model for model in stage_models({}) if model.key == stage)
    for control in model.controls:
        for value in (1e300, -1e300, 1e150, 1e-300, 0.0):
            for answer in (model.solve, model.toml):
                said = words_of(answer, {control.key: value})
                assert "math" not in said
                assert "nan" not in said
    assert capfd.readouterr() == ("", "")  # nor does a library below say something of its own
