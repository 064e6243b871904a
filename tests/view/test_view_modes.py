"""The picture of natural modes: what is drawn, from where, and how large."""

import numpy as np
import pytest

from lumpedcable.results import OutputError
from lumpedcable.view import ModeShapes, plot_modes
from lumpedcable.view.modes import MOST_PANELS, mode_figure

X = np.linspace(0.0, 100.0, 41)
SINE = np.sin(np.pi * X / 100.0)


def shapes(nodes, *modes):
    """Shapes of one line: for each mode its displacements (nodes, 3)."""
    titles = [f"mode {k + 1}: {k + 1} Hz" for k in range(len(modes))]
    return ModeShapes({"rope": nodes}, {"rope": np.array(modes)}, titles)


def along(component, values=SINE):
    motion = np.zeros((values.size, 3))
    motion[:, component] = values
    return motion


LEVEL = np.column_stack([X, 0 * X, 0 * X])
SAGGED = np.column_stack([X, 0 * X, -10.0 * SINE])
UPRIGHT = np.column_stack([0 * X, 0 * X, -X])


def drawn(ax):
    """The three curves of a panel: the opposite, the mode, the shape at equilibrium."""
    opposite, mode, rest = (line.get_xydata() for line in ax.lines)
    return opposite, mode, rest


@pytest.mark.parametrize(
    ("nodes", "motion", "labels"),
    [
        (LEVEL, along(2), ("x (m)", "z (m)")),
        (LEVEL, along(1), ("x (m)", "y (m)")),  # seen from above
        (LEVEL, along(0), ("x (m)", "z (m)")),  # along the line
        (SAGGED, along(2), ("x (m)", "z (m)")),
        (SAGGED, along(1), ("x (m)", "y (m)")),
        (SAGGED, along(2, 0 * X), ("x (m)", "z (m)")),  # nothing moves
        (UPRIGHT, along(0), ("x (m)", "z (m)")),
        (UPRIGHT, along(1), ("y (m)", "z (m)")),
    ],
)
def test_a_mode_is_seen_from_where_it_moves(nodes, motion, labels):
    ax = mode_figure(shapes(nodes, motion), "Modes").axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels
    opposite, mode, rest = drawn(ax)
    plane = ["xyz".index(label[0]) for label in labels]
    assert rest == pytest.approx(nodes[:, plane])
    assert opposite + mode == pytest.approx(2.0 * rest)


def test_the_size_suits_the_shape_and_not_the_mode():
    for scale in (1e-6, 1.0, 1e6):
        figure = mode_figure(shapes(SAGGED, scale * along(2), scale * along(1)), "Modes")
        for ax, most in zip(figure.axes, (4.0, 5.0), strict=True):
            _, mode, rest = drawn(ax)
            # two fifths of the sag, or a twentieth of the length where there is none
            assert np.abs(mode - rest).max() == pytest.approx(most)


def test_a_shape_as_high_as_long_keeps_its_proportions():
    figure = mode_figure(shapes(np.column_stack([X, 0 * X, -X]), along(2)), "Modes")
    assert figure.axes[0].get_aspect() == 1.0
    assert "scales" not in figure.legends[0].get_title().get_text()
    flat = mode_figure(shapes(LEVEL, along(2)), "Modes")
    assert flat.axes[0].get_aspect() == "auto"
    assert "The two scales differ." in flat.legends[0].get_title().get_text()


def test_motion_along_the_line_is_drawn_across_it_and_says_so():
    figure = mode_figure(shapes(LEVEL, along(0), along(2)), "Modes")
    first, second = figure.axes
    assert first.get_title() == "mode 1: 1 Hz, along the line"
    assert second.get_title() == "mode 2: 2 Hz"
    assert "Motion along a line is drawn across it." in figure.legends[0].get_title().get_text()
    _, mode, rest = drawn(first)
    assert mode[:, 0] == pytest.approx(X)
    assert mode[:, 1] == pytest.approx(5.0 * SINE)
    assert rest[:, 1] == pytest.approx(0.0)


def test_more_modes_than_panels():
    figure = mode_figure(shapes(LEVEL, *[along(2)] * (MOST_PANELS + 3)), "Many")
    assert len(figure.axes) == MOST_PANELS
    assert "The first 12 of 15 modes." in figure.legends[0].get_title().get_text()
    # one plane for all: labels at the margins only
    assert sum(bool(ax.get_ylabel()) for ax in figure.axes) == 4
    assert figure.get_suptitle() == "Many"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "at equilibrium",
        "mode",
        "half a period later",
    ]


def test_several_lines_share_one_scale():
    nodes = {"a": SAGGED, "b": SAGGED[:3] - np.array([0.0, 0.0, 5.0])}
    motion = {"a": along(2)[None], "b": along(2, SINE[:3])[None]}
    ax = mode_figure(ModeShapes(nodes, motion, ["mode 1"]), "Modes").axes[0]
    assert len(ax.lines) == 6
    size = {name: np.ptp(motion[name][0, :, 2]) for name in nodes}
    for name, first in (("a", 0), ("b", 3)):
        moved = ax.lines[first + 1].get_xydata() - ax.lines[first + 2].get_xydata()
        assert np.ptp(moved[:, 1]) == pytest.approx(4.0 * size[name])


def test_a_body_moves_with_its_line():
    # a square that turns about its middle at the end of a line that stands still
    square = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1], [-1, 0, -1]])
    turned = np.column_stack([square[:, 2], 0 * square[:, 0], -square[:, 0]])
    modes = ModeShapes(
        {"rope": UPRIGHT}, {"rope": 0.0 * UPRIGHT[None]}, ["mode 1"],
        {"box": square}, {"box": turned[None] / np.sqrt(2.0)},
    )  # fmt: skip
    ax = mode_figure(modes, "Modes").axes[0]
    assert len(ax.lines) == 6
    opposite, mode, rest = (line.get_xydata() for line in ax.lines[3:])
    assert rest == pytest.approx(square[:, [0, 2]])
    assert 0.5 * (mode + opposite) == pytest.approx(rest)
    # two fifths of the body's 2 m, the smaller extent, where it moves the most
    assert np.linalg.norm(mode - rest, axis=1) == pytest.approx(0.8)


def test_files_and_formats(tmp_path):
    made = plot_modes(shapes(LEVEL, along(2)), "Modes", tmp_path / "new" / "m", ("png", "svg"))
    assert made == [tmp_path / "new" / "m.png", tmp_path / "new" / "m.svg"]
    assert all(path.stat().st_size > 5000 for path in made)
    with pytest.raises(OutputError, match="cannot draw in the format 'gif', expected one of pdf"):
        plot_modes(shapes(LEVEL, along(2)), "Modes", tmp_path / "m", ("gif",))
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="expected a folder for the pictures, found"):
        plot_modes(shapes(LEVEL, along(2)), "Modes", tmp_path / "file" / "m")
