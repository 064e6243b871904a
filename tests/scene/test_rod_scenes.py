"""Inextensible lines in the scene language: what they ask of the solver."""

from pathlib import Path

import pytest

from lumpedcable.scene import SceneError, load_study

RESTRAINT = Path(__file__).parents[2] / "configs" / "restraint.toml"


def test_single_precision_is_refused():
    # a length held to dt squared: single precision's 4e-6 m at 40 m over (4 ms)^2 are 0.2 m/s2 anywhere
    with pytest.raises(SceneError) as caught:
        load_study(RESTRAINT, ["solver.dtype=float32"])
    told = {(fault.key, fault.message) for fault in caught.value.faults}
    words = 'expected "float64" where lines are inextensible, found "float32"'
    assert told == {("solver.dtype", words)}
