"""Natural modes from Python: what the command writes, as an object."""

import json

import numpy as np
import pytest
from modal_runs import STRING

import lumpedcable as lc
from lumpedcable import exact

TITLED = f'title = "A string"\ndimensions = 2\n{STRING}\n[sweep]\n"lines.rope.mass" = [1, 4]\n'


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(TITLED)
    return path


def test_modes_are_an_object(scene, tmp_path, capsys):
    found = lc.modes(scene, segments=64, count=2, run=1)
    known = exact.string_frequencies(105.0, 50e3, 4.0 * 100 / 105, 2)
    assert found.frequency == pytest.approx(known, rel=1e-3)
    assert found.square == pytest.approx((2 * np.pi * found.frequency) ** 2)
    assert found.damping is None
    assert found.nodes["rope"].shape == (65, 3)
    assert found.shapes["rope"][0, 32] == pytest.approx([0, 1, 0])
    # half of the line's mass, of a sine
    assert found.mass == pytest.approx(200.0, rel=1e-3)
    assert repr(found).startswith(f"NaturalModes({found.title}: {found.frequency[0]:.4g}, ")
    assert found.title.startswith("A string: ")
    assert found.remarks[0].startswith("Shares are of the kinetic energy. Motion in x and y only")
    (made,) = found.save(tmp_path / "out")
    told = json.loads(made.read_text())
    assert [mode["frequency"] for mode in told["modes"]] == pytest.approx(list(found.frequency))
    assert told["conditions"] == found.remarks
    assert [path.name for path in found.plot(tmp_path / "out", ["svg"])] == ["modes.svg"]
    assert list(found.plot()) == ["modes"]
    found.report()
    assert f"{found.frequency[0]:.6g}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"count": 0}, "count: expected a whole number of at least 1, found 0"),
        ({"count": 1.5}, "count: expected a whole number of at least 1, found 1.5"),
        ({"run": 2}, "run: expected one from 0 to 1"),
    ],
)
def test_wrong_questions_are_told(scene, asked, said):
    with pytest.raises(ValueError, match=said):
        lc.modes(scene, **asked)


def test_no_rest_is_told(tmp_path):
    loose = TITLED.replace("start = { fixed = [0, 0, 0] }", 'start = "free"').replace(
        "dimensions = 2", "dimensions = 2\ngravity = 9.81"
    )
    (tmp_path / "scene.toml").write_text(
        loose.replace("end = { fixed = [105, 0, 0] }", 'end = "free"')
    )
    with pytest.raises(ValueError, match="no static equilibrium"):
        lc.modes(tmp_path / "scene.toml")
