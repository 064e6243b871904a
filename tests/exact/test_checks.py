"""Numbers that are no numbers are refused in words, by every closed form."""

import numpy as np
import pytest

import lumpedcable.exact as exact


def law(strain):
    return 1e6 * np.asarray(strain)


NODES = {"lengths": [1.0, 1.0], "loads": np.zeros((3, 3)), "strain": exact.linear_strain(1e6)}
LINE = {"span": 60.0, "drop": 16.0, "weight": 40.0}
LOADED = {**LINE, "load": 2e4, "place": 30.0}
STRAIGHT = {"span": 60.0, "drop": 16.0, "load": 2e4, "place": 30.0}
DRAGGED = {**LINE, "length": 30.0, "traction_weight": 5.0, "load": 100.0}
IDEAL = {"span": 60.0, "tension": 80e3, "mass": 2e3, "gravity": 9.81, "place": 20.0, "rise": 1.0}
BEAM = {"length": 2.0, "EI": 3.0}

# function and numbers it takes; "EA" may be infinite, for a line that does not stretch
TAKEN = {
    "IdealHighline": IDEAL,
    "LinearRelease": {"length": 9.0, "EA": 1e6, "mass": 2.0, "tension0": 1e3, "ramp_time": 0.01},
    "RelaxingRelease": {
        "length": 9.0, "EA": 1e6, "mass": 2.0, "tension0": 1e3, "branches": ((1e6, 0.1),),
        "ramp_time": 0.01, "modes": 20,
    },
    "HangingRod": {"length": 9.0, "weight": 5.0, "end_force": 3.0, "strain": NODES["strain"]},
    "beam_frequencies": {**BEAM, "mass": 1.0, "count": 2},
    "cantilever_deflection": {"x": 1.0, **BEAM, "load": 5.0},
    "drag_line": {"span": 10.0, "length": 12.0, "drag": 30.0},
    "dragged_from_length": {**DRAGGED, "traction_length": 33.0},
    "dragged_from_tension": {**DRAGGED, "tension": 4e3},
    "elastic_catenary": {
        "span": 10.0, "rise": 5.0, "length": 20.0, "EA": 1e9, "weight": 3.0,
        "seabed": 0.0, "friction": 0.5,
    },
    "elastic_pendulum_periods": {"length": 5.0, "EA": 1e6, "mass": 10.0, "gravity": 9.81},
    "hanging_chain_frequencies": {"length": 5.0, "count": 2, "gravity": 9.81},
    "hanging_nodes": {"start": np.zeros(3), **NODES, "end_force": np.ones(3)},
    "highline_from_length": {**LINE, "length": 63.0},
    "highline_from_sag": {**LINE, "sag": 5.0},
    "highline_from_tension": {**LINE, "tension": 8e4},
    "inverse_tension": {"tension": law, "T0": 1e3},
    "irvine_parameter": {"span": 10.0, "H": 100.0, "weight": 2.0, "EA": 1e6},
    "least_tension": LINE,
    "linear_strain": {"EA": 1e6},
    "loaded_from_length": {**LOADED, "length": 63.0},
    "loaded_from_tension": {**LOADED, "tension": 8e4},
    "lower_convex_envelope": {"tension": law, "strain_lo": 0.0, "strain_hi": 0.1},
    "pendulum_period": {"length": 5.0, "amplitude": 0.1, "gravity": 9.81},
    "pinned_nodes": {"start": np.zeros(3), "end": np.array([2.2, 0.0, 0.0]), **NODES},
    "ramped_release": {
        "tension": law, "mass": 2.0, "ramp_time": 0.01, "strain0": 0.1, "end_tension": 5.0,
    },
    "release_wave": {"tension": law, "mass": 2.0, "strain0": 0.1, "end_tension": 5.0},
    "released_strain": {"tension": law, "strain0": 0.1, "end_tension": 5.0},
    "rod_frequencies": {"length": 5.0, "EA": 1e6, "mass": 2.0, "count": 2},
    "rolled_beam": {"s": 1.0, "moment": 2.0, "EI": 3.0},
    "sagged_cable_frequencies": {
        "span": 10.0, "H": 100.0, "mass": 2.0, "parameter": 3.0, "count": 2
    },
    "simply_supported_deflection": {"x": 1.0, **BEAM, "load": 5.0},
    "stage_shape": {"stage": "erection", "time": 20.0, "speed": 1.0, "drop": 2.0, "traction": 4e3},
    "straight_from_length": {**STRAIGHT, "length": 63.0},
    "straight_from_tension": {**STRAIGHT, "tension": 8e4},
    "string_frequencies": {"length": 5.0, "tension": 100.0, "mass": 2.0, "count": 2},
    "tensioned_beam_frequencies": {**BEAM, "tension": 5.0, "mass": 1.0, "count": 2},
    "tip_loaded_cantilever": {**BEAM, "load": 5.0},
}  # fmt: skip

# what is made by the functions above, and what takes no numbers
MADE = {
    "STAGES", "STANDARD_GRAVITY", "Catenary", "ChainShape", "DragLine", "Envelope",
    "EnvelopePiece", "Highline", "Law", "RampedRelease", "ReleaseWave", "Slider", "Stage",
    "StageShape", "StraightHighline", "StrainOfTension", "WavePiece", "strain_of_tension",
}  # fmt: skip

CASES = [
    (name, key, bad)
    for name, numbers in TAKEN.items()
    for key, value in numbers.items()
    if isinstance(value, float | np.ndarray) and key not in ("x", "s")  # where a curve is asked for
    for bad in (np.nan, np.inf, -np.inf)
    if not (key == "EA" and bad == np.inf)
]


def test_all_that_takes_numbers_is_looked_at():
    assert set(exact.__all__) == TAKEN.keys() | MADE


@pytest.mark.parametrize("name", TAKEN)
def test_sound_numbers_are_taken(name):
    getattr(exact, name)(**TAKEN[name])


@pytest.mark.parametrize(("name", "key", "bad"), CASES)
def test_what_is_not_finite_is_refused(name, key, bad):
    numbers = TAKEN[name]
    wrong = np.full(np.shape(numbers[key]), bad) if np.ndim(numbers[key]) else bad
    with pytest.raises(ValueError, match=r"nan|inf|finite"):
        getattr(exact, name)(**{**numbers, key: wrong})


@pytest.mark.parametrize("name", ["span", "tension", "mass", "gravity"])
def test_an_ideal_cable_with_a_negative_number_is_refused(name):
    with pytest.raises(ValueError, match=f"{name}.* found -|between the posts"):
        exact.IdealHighline(**{**IDEAL, name: -1.0})
