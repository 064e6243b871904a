"""What lines sweep when one parts: areas and speeds of closed forms, and where there is no picture."""

import h5py
import numpy as np
import pytest
from synthetic_result import LENGTH, snapback

from lumpedcable.view.plot import figures_of

SAG = 3.0  # m
ONE = {"pretensions": (1e3,), "break_times": (5e-3,), "swept": False, "sag": SAG}


def cells(figure, panel=0):
    """Corners (cell, 4, 2) and colours (cell,) of what a panel shows."""
    (drawn,) = figure.axes[panel].collections
    corners = np.array([path.vertices[:4] for path in drawn.get_paths()])
    return corners, np.asarray(drawn.get_array())


def areas(corners):
    """Area of each four-sided cell (m2), by the shoelace formula."""
    x, y = corners[..., 0], corners[..., 1]
    return 0.5 * np.abs(np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1))


def turned(path, *, y, z):
    """Make the line's heights so much of them sideways and upright."""
    with h5py.File(path, "r+") as file:
        place = file["lines/rope/position"]
        height = place[..., 2]
        place[..., 1], place[..., 2] = y * height, z * height
    return path


def test_what_is_swept_has_the_area_and_the_speeds_of_the_motion(tmp_path):
    path = snapback(tmp_path / "a.h5", segments=40, **ONE)
    figure = figures_of(path)["swept"]
    corners, speeds = cells(figure)
    # a parabola of the area 2/3 L s goes from s down to -s and back up to -s / 2; strains are 7e-4
    assert areas(corners).sum() == pytest.approx(2.5 * 2.0 / 3.0 * LENGTH * SAG, rel=3e-3)
    assert np.abs(corners[..., 1]).max() == pytest.approx(SAG, rel=1e-3)
    assert (np.diff(speeds) >= 0.0).all()  # the fastest in front
    with h5py.File(path) as file:
        fastest = np.abs(file["lines/rope/velocity"][...]).max()
    assert speeds.max() == pytest.approx(fastest)
    start = figure.axes[0].lines[0]
    np.testing.assert_allclose(start.get_ydata()[[0, 20]], [0.0, -SAG], atol=2e-3)
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == ("x (m)", "z (m)")
    assert figure.axes[1].get_ylabel() == "largest speed there (m/s)"


@pytest.mark.parametrize(
    ("y", "z", "names"),
    [
        (0.0, 1.0, {"swept"}),
        (1.0, 0.0, {"swept_above"}),
        (1.0, 1.0, {"swept", "swept_above"}),
        (1.0, 0.1, {"swept_above"}),  # 0.3 m of 60
    ],
)
def test_it_is_seen_from_where_it_has_a_breadth(tmp_path, y, z, names):
    path = turned(snapback(tmp_path / "a.h5", segments=10, **ONE), y=y, z=z)
    figures = figures_of(path)
    assert {name for name in figures if name.startswith("swept")} == names
    if "swept_above" in names:
        corners, _ = cells(figures["swept_above"])
        assert np.abs(corners[..., 1]).max() == pytest.approx(SAG, rel=1e-3)
        assert figures["swept_above"].axes[0].get_ylabel() == "y (m)"


def test_a_line_that_recoils_along_itself_sweeps_nothing(tmp_path):
    path = snapback(tmp_path / "a.h5", segments=10, **ONE | {"sag": 0.0})
    with h5py.File(path, "r+") as file:  # nor does it on a slope
        place = file["lines/rope/position"]
        place[..., 2] = 0.5 * place[..., 0]
    assert not any(name.startswith("swept") for name in figures_of(path))


def test_a_run_that_goes_wrong_is_drawn_until_then(tmp_path):
    many = {"pretensions": (1e3, 2e3), "swept": True}
    figure = figures_of(snapback(tmp_path / "a.h5", segments=10, failed=(1,), **ONE | many))[
        "swept"
    ]
    whole, half = (areas(cells(figure, panel)[0]).sum() for panel in (0, 1))
    # it fails at 100 ms, when the parabola is at cos(2 pi / 3) of its height: 1.5 of 2.5 ways
    assert half / whole == pytest.approx(1.5 / 2.5, rel=0.02)
