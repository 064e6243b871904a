"""Films of a run: their frames, their clock, what they refuse."""

from itertools import pairwise

import h5py
import numpy as np
import pytest
import synthetic_result
from command_line import refused, say
from PIL import Image
from synthetic_result import TIMES

from lumpedcable.results.sound import SoundFile
from lumpedcable.view import animate_result, animation, figures_of, style


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "r.h5"
    return synthetic_result.snapback(path, segments=12, sag=6.0, padded=1)


def test_a_gif_shows_the_run_in_slow_motion(file):
    said = say(file.parent, "animate", file.name, "--run", "2", "--seconds", "0.8", "--fps", "5")
    assert (said.code, said.out, said.err) == (0, "r.gif\n", "")
    assert sorted(p.name for p in file.parent.iterdir()) == ["r.gif", "r.h5"]
    with Image.open(file.parent / "r.gif") as film:
        assert film.n_frames == 4
        assert film.info["duration"] == 200
        frames = []
        for k in range(4):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), float))
    # the line swings, so that every frame is another
    for before, after in pairwise(frames):
        assert (abs(after - before).max(axis=2) > 60).sum() > 100


@pytest.mark.parametrize(("fps", "hundredths"), [(15, 7), (7, 14), (90, 2)])
def test_a_gif_lasts_as_long_as_it_says(file, tmp_path, monkeypatch, fps, hundredths):
    told, laid_out = [], animation._Film.__init__
    monkeypatch.setattr(
        animation._Film, "__init__",
        lambda film, result, run, seconds, more: (
            told.append(seconds), laid_out(film, result, run, seconds, more),
        )[1],
    )  # fmt: skip
    made = animate_result(file, tmp_path / "r.gif", run=2, seconds=0.26, fps=fps)
    with Image.open(made) as film:
        lasts = []
        for k in range(film.n_frames):
            film.seek(k)
            lasts.append(film.info["duration"])
    assert min(lasts) == 10 * hundredths
    assert 1e-3 * sum(lasts) == pytest.approx(told[0], rel=1e-9)
    assert told[0] == pytest.approx(0.26, abs=0.5e-2 * hundredths)


def test_a_frame_holds_the_file_s_values(file):
    with SoundFile.open(file) as result, style.styled():
        film = animation._Film(result, 4, 10.0, ({}, (), (), None))
        tension, place = result.line("rope").tension(4), result.line("rope").position(4)
        for sample in (0, 77):
            film.show(sample)
            assert np.allclose(film.curves[0].get_ydata(), tension[sample, :12] * 1e-3)
            ends = np.array([film.shapes[0].get_segments()[k][k] for k in (0, -1)])
            assert np.allclose(ends, place[sample, [0, 12]][:, [0, 2]])
        assert film.clock.get_text() == "77 ms, 50× slower"


def test_a_straight_line_is_not_seen_to_tremble(tmp_path):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=12, sag=1.5e-13)
    with SoundFile.open(path) as result, style.styled():
        film = animation._Film(result, 0, 10.0, ({}, (), (), None))
        assert film.top.get_ylabel() == "z (m)"
        assert np.ptp(film.top.get_ylim()) > 1.0


def test_an_mp4_is_one(file, tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    made = animate_result(file, tmp_path / "film.mp4", seconds=0.4, fps=5)
    assert made.read_bytes()[4:8] == b"ftyp"


def test_what_cannot_be_filmed_is_told(file, tmp_path):
    assert "ends in .gif or .mp4" in refused(tmp_path, "animate", file, "-o", "film.avi")
    assert "expected a run from 0 to 7, found 8" in refused(tmp_path, "animate", file, "--run", "8")
    for long in ("0", "inf", "1e12", "nan"):
        said = refused(tmp_path, "animate", file, "--seconds", long)
        assert f"expected a film of some length, of 3600 s at most, found {float(long):g} s" in said
    blind = synthetic_result.snapback(tmp_path / "b.h5", segments=4, fields=("position",))
    assert "no positions with tensions" in refused(tmp_path, "animate", blind)


def test_waves_that_reach_into_a_film_are_not_cut_off(file):
    with SoundFile.open(file) as result, style.styled():
        plain = animation._Film(result, 4, 10.0, ({}, (), (), None)).top.get_ylim()

        def water(t, places):
            # a little below the top of the picture, with crests above it
            return plain[1] - 0.2 + 0.6 * np.sin(places[:, 0] - 40.0 * t)

        film = animation._Film(result, 4, 10.0, ({}, (), (), water))
        assert film.top.get_ylim()[0] == plain[0]
        assert film.top.get_ylim()[1] > plain[1] + 0.39
        film.show(3)
        (outline,) = film.sea.get_paths()
        exact = water(film.saved[3], film.places)
        assert outline.vertices[1:-2, 1] == pytest.approx(exact, abs=1e-5)
        # what is far above the picture is not in it
        film = animation._Film(result, 4, 10.0, ({}, (), (), lambda t, p: water(t, p) + 1e3))
        assert film.sea is None
        assert film.top.get_ylim() == plain


def test_dollars_open_no_formula_and_one_segment_has_a_curve(tmp_path):
    title = r"Shackle for $50 or $60, costs \frac{ each"
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=1, scene="")
    with h5py.File(path, "r+") as changed:
        changed.attrs["title"] = title
    with SoundFile.open(path) as result, style.styled():
        film = animation._Film(result, 0, 10.0, ({}, (), (), None))
        words = film.figure.get_suptitle()
        (curve,) = film.curves
        x, y = curve.get_data()
    assert words.replace("\n", " ").startswith(title)
    np.testing.assert_array_equal(x, [0.0, synthetic_result.LENGTH])
    assert y[0] == y[1] > 0.0
    figure = next(fig for name, fig in figures_of(path).items() if name.startswith("end_speed"))
    figure.canvas.draw()  # no error of a formula
    assert not figure._suptitle.get_parse_math()
    plain = [label for ax in figure.axes for label in ax.get_xticklabels()]
    assert plain
    assert all(label.get_parse_math() for label in plain)


def test_names_that_are_alike_but_for_signs_make_pictures_of_their_own(tmp_path):
    path = synthetic_result.snapback(tmp_path / "r.h5", pretensions=(45e3,), break_times=(5e-3,))
    with h5py.File(path, "r+") as changed:
        for name, value in (("mid_", 1.0), ("mid__", 2.0)):
            table = changed.create_dataset(f"measures/{name}", data=np.full((1, len(TIMES)), value))
            table.attrs.update(units="m", long_name=name)
    made = [name for name in figures_of(path) if name.startswith("measure_")]
    assert sorted(made) == sorted(set(made))
    assert len(made) == 2
