"""Figures of bodies show the file's places and speeds."""

import numpy as np
import pytest

from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.view import figures_of

TIMES = np.linspace(0.0, 4.0, 5)


def test_a_body_is_drawn_by_its_way_and_speed(tmp_path):
    path = tmp_path / "r.h5"
    # one is pulled along (3, 4) at 10 m/s, the other stays
    way = np.stack([6.0 * TIMES + 1.0, 8.0 * TIMES, 0 * TIMES], axis=-1)
    position = np.stack([way, np.ones((5, 3))])
    velocity = np.stack([np.tile([6.0, 8.0, 0.0], (5, 1)), np.zeros((5, 3))])
    shape = ("run", "time", "xyz")
    variables = [
        Variable("bodies/ship/position", shape, "f8", "m"),
        Variable("bodies/ship/velocity", shape, "f8", "m/s"),
    ]
    known = {
        "time": Coordinate(TIMES, "s"),
        "case": Coordinate(np.array(["pulled", "left"], object), "1", "", ("run",)),
    }
    dims = {"run": 2, "time": 5, "xyz": 3}
    with ResultWriter(
        path, dims=dims, variables=variables, coordinates=known, attributes={}
    ) as writer:
        writer.write("bodies/ship/position", position)
        writer.write("bodies/ship/velocity", velocity)
        writer.finish()
    figures = figures_of(path)
    assert list(figures) == ["body_ship"]
    far, fast = figures["body_ship"].axes
    assert far.lines[0].get_ydata() == pytest.approx(10.0 * TIMES)
    assert fast.lines[0].get_ydata() == pytest.approx(np.full(5, 10.0))
    assert far.lines[1].get_ydata() == pytest.approx(np.zeros(5))
    # a curve is called by its case
    (legend,) = figures["body_ship"].legends
    assert [text.get_text() for text in legend.get_texts()] == ["pulled", "left"]
