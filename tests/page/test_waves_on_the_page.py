"""Waves on the page and in films: the surface is where the scene's own sines have it."""

import numpy as np
import pytest
from page.browser import chromium, visit
from page.test_bodies_on_the_page import TIMES, TRANSFER, transfer_file
from page.test_recorded_page import unpacked

from lumpedcable.page.filmed import beside_lines
from lumpedcable.page.open import write_recorded
from lumpedcable.page.recorded import recorded
from lumpedcable.results.sound import SoundFile
from lumpedcable.study.moved import study_of_text, waves_of
from lumpedcable.view import animation, style

SEA = """
[sea]
height = 3
period = 6
components = 3
direction = 1.2
"""
LONG = TRANSFER.replace("size = [40.0, 12.0, 8.0]", "size = [120.0, 12.0, 8.0]")


@pytest.fixture
def file(tmp_path):
    assert LONG != TRANSFER
    return transfer_file(tmp_path, LONG + SEA)


def sines(waves, t, x, y):
    """Height of the surface (m) by the sum as it is written in the documentation."""
    along = x * np.cos(1.2) + y * np.sin(1.2)
    parts = zip(waves.amplitude, waves.omega, waves.number, waves.phase, strict=True)
    return sum(a * np.cos(w * t - k * along + e) for a, w, k, e in parts)


@pytest.fixture
def waves():
    found = waves_of(study_of_text(LONG + SEA).scene)
    # equal heights that share out the energy of a sea of 3 m
    assert found.amplitude == pytest.approx(np.full(3, 0.75 * np.sqrt(2.0 / 3.0)))
    assert found.number == pytest.approx(found.omega**2 / 9.80665)
    assert (found.direction, found.level, found.ramp) == (1.2, 0.0, 0.0)
    return found


def test_a_page_holds_the_waves_of_its_runs(file, waves):
    head = recorded(file)
    told = head["waves"]
    table = unpacked(head.pack.text(), told["data"])
    assert table[0] == pytest.approx(np.array(waves[:4]), rel=1e-6)
    assert told["runs"] == [{"direction": 1.2, "level": 0.0, "ramp": 0.0}]
    assert head["surroundings"][0]["surface"] == 0.0


def test_a_page_without_waves_has_none(tmp_path):
    head = recorded(transfer_file(tmp_path, TRANSFER))
    assert head["waves"] is None


def test_a_film_shows_the_surface_across_the_picture(file, waves):
    with SoundFile.open(file) as result, style.styled():
        film = animation._Film(result, 0, 1.0, beside_lines(result, 0))
        for sample in (0, 3):
            film.show(sample)
            (outline,) = film.sea.get_paths()
            y, z = outline.vertices[1:-2].T  # the first and the last close it at the bottom
            low, high = film.top.get_xlim()
            assert (y[0], y[-1]) == pytest.approx((low, high))
            assert np.ptp(z) > 0.5
            assert z == pytest.approx(sines(waves, TIMES[sample], film.places[:, 0], y))
            assert outline.vertices[0][1] == film.top.get_ylim()[0]


def test_a_browser_draws_them_where_they_are(file, waves, tmp_path):
    page = write_recorded(file, tmp_path / "page.html").as_uri()
    with chromium() as browser:
        for t in (0.0, 2.6):
            with visit(browser, f"{page}#t={t}") as shown:
                x, y, z = map(float, shown.locator("html").get_attribute("data-water").split(","))
                box = list(map(float, shown.locator("html").get_attribute("data-box").split(",")))
            # a screen's share of the waves' height: the page has straight lines between its points
            assert z == pytest.approx(sines(waves, t, x, y), abs=0.02)
            # the room holds a ship of 120 by 12 by 8 m with its post as it heaves and rolls, and no more
            heave, roll = 1.0 + 2.0 * np.sin(np.pi * TIMES / 4.0), 0.1 * np.sin(0.4 * np.pi * TIMES)
            c, s = np.cos(roll), np.abs(np.sin(roll))
            wide, low, high = 6.0 * c + 4.0 * s, heave - 4.0 * c - 6.0 * s, heave + 15.0 * c
            lowest, highest = [-60.0, -wide.max(), low.min()], [60.0, 50.0, high.max()]
            assert box == pytest.approx([*lowest, *highest], abs=0.01)
