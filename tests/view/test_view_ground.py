"""Pictures of shapes show the bed and the water's surface where they are."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from synthetic_result import snapback

from lumpedcable.results.sound import SoundFile
from lumpedcable.view import style
from lumpedcable.view.general import shape_figure
from lumpedcable.view.ground import BED, WATER
from lumpedcable.view.groups import groups


def shown(tmp_path, scene):
    """The panel of a line that swings by 15 m about z = 0, and the note under it."""
    path = snapback(
        tmp_path / "a.h5", pretensions=(45e3,), broken=False, sag=15.0, segments=20, scene=scene
    )
    with SoundFile.open(path) as result, style.styled():
        figure = shape_figure(result, groups(result)[0])
        figure.draw_without_rendering()
        (ax,) = (ax for ax in figure.axes if ax.get_label() != "<colorbar>")
        return ax, figure.get_supxlabel()


def level(ax, colour):
    (line,) = (line for line in ax.lines if line.get_color() == colour)
    return line.get_ydata()[0]


def test_a_bed_in_sight_and_a_surface_are_where_the_scene_has_them(tmp_path):
    ax, note = shown(tmp_path, "[water]\nsurface = 4.0\n[seabed]\nheight = -6.0")
    assert (level(ax, BED), level(ax, WATER)) == (-6.0, 4.0)
    assert note == "Brown: the bed; light blue: the water's surface."


def test_a_bed_a_little_below_makes_the_picture_higher(tmp_path, caplog):
    bare, _ = shown(tmp_path, "[water]")
    lowest = bare.get_ylim()[0]
    ax, _ = shown(tmp_path, f"[seabed]\nheight = {lowest - 1.0}")
    assert caplog.messages == []  # nothing said of limits that one scale for both axes cannot keep
    assert level(ax, BED) == pytest.approx(lowest - 1.0)
    assert ax.get_ylim()[0] < lowest - 1.0


@pytest.mark.parametrize("scene", ["[seabed]\nheight = -500", "[water]", "no TOML"])
def test_what_is_far_away_or_not_told_is_not_drawn(tmp_path, scene):
    ax, note = shown(tmp_path, scene)
    assert len(ax.lines) == 5  # the shapes
    assert note == ""


def test_a_profile_is_its_curve(tmp_path):
    profile = "profile = { x = [0, 30, 60], depth = [0, 0, 6] }"
    ax, note = shown(tmp_path, f"[seabed]\nheight = -2.0\n{profile}")
    (drawn,) = (c for c in ax.collections if isinstance(c, LineCollection))
    (points,) = drawn.get_segments()
    # flat before the second point, and straight on beyond the last one
    np.testing.assert_allclose(np.interp([-100, 15, 60, 70], *points.T), [-2, -2, -8, -10])
    assert note == "Brown: the bed."


def test_a_swept_bed_is_that_of_each_run(tmp_path):
    path = snapback(
        tmp_path / "a.h5", broken=False, segments=4,
        scene='[seabed]\nheight = -1\n[lines.rope.end.held]\npretension = 1.0',
    )  # fmt: skip
    with SoundFile.open(path) as result:
        key = result.axes[0].key
        assert key == "lines.rope.end.held.pretension"
        found = [result.scene_of(k)["lines"]["rope"]["end"]["held"] for k in range(result.runs)]
        assert [f["pretension"] for f in found] == result.axes[0].values.tolist()
        assert result.scene["lines"]["rope"]["end"]["held"]["pretension"] == 1.0
