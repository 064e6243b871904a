"""Figures of bodies show the file's places and speeds."""

import numpy as np
import pytest

from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.view import figures_of, style

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


def test_rounding_of_what_stays_is_not_drawn_large(tmp_path):
    # a body that rests 5 m from the origin, to the last bits
    noise = 4e-14 * np.sin(np.arange(15.0)).reshape(1, 5, 3)
    shape = ("run", "time", "xyz")
    variables = [
        Variable("bodies/buoy/position", shape, "f8", "m"),
        Variable("bodies/buoy/velocity", shape, "f8", "m/s"),
    ]
    dims = {"run": 1, "time": 5, "xyz": 3}
    with ResultWriter(
        tmp_path / "r.h5", dims=dims, variables=variables,
        coordinates={"time": Coordinate(TIMES, "s")}, attributes={},
    ) as writer:  # fmt: skip
        writer.write("bodies/buoy/position", np.array([3.0, 0.0, -4.0]) + noise)
        writer.write("bodies/buoy/velocity", noise)
        path = writer.finish()
    for ax in figures_of(path)["body_buoy"].axes:
        assert np.ptp(ax.get_ylim()) > 1e-6
    low, high = style.limits(1e3 + noise)
    assert 1e-3 < high - low < 1e3
    # what is seen at all keeps its own scale
    low, high = style.limits(np.array([1e3, 1e3 + 0.01]))
    assert high - low == pytest.approx(0.0108)


def test_a_winch_is_drawn_by_what_it_pays_out(tmp_path):
    length, speed = 50.0 - 0.5 * TIMES**2, -TIMES
    variables = [
        Variable(f"lines/rope/{name}", ("run", "time"), "f8", unit)
        for name, unit in (("payout", "m"), ("payout_speed", "m/s"))
    ]
    with ResultWriter(
        tmp_path / "r.h5", dims={"run": 1, "time": 5, "lines/rope/node": 2}, variables=variables,
        coordinates={"time": Coordinate(TIMES, "s")}, attributes={},
    ) as writer:  # fmt: skip
        writer.write("lines/rope/payout", length[None])
        writer.write("lines/rope/payout_speed", speed[None])
        path = writer.finish()
    figures = figures_of(path)
    assert list(figures) == ["payout_rope"]
    out, fast = figures["payout_rope"].axes
    assert out.lines[0].get_ydata() == pytest.approx(length)
    assert fast.lines[0].get_ydata() == pytest.approx(speed)
    assert out.get_ylabel() == "unstretched length paid out (m)"
    assert (
        out.get_ylim()[0] > 40.0
    )  # a length of which little is paid out is drawn without its zero
    assert fast.get_ylim()[0] < 0.0 <= fast.get_ylim()[1]
