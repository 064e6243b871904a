"""The page of a results file in a browser: it draws, it scrubs, it says what the file holds."""

import numpy as np
import pytest
import synthetic_result
from page.browser import (
    LAPTOP,
    PHONE,
    chromium,
    drawn_anew,
    picture,
    text_of,
    value_of,
    visit,
)
from page.test_bodies_on_the_page import transfer

from lumpedcable.page import recorded
from lumpedcable.page.open import write_recorded
from lumpedcable.results import open_result

__all__ = ["transfer"]  # a fixture


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("shown") / "r.h5"
    return synthetic_result.snapback(path, segments=20, sag=3.0, failed=(5,))


@pytest.fixture(scope="module")
def url(file):
    return write_recorded(file, file.with_name("page.html")).as_uri()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_it_draws_and_needs_nothing(browser, url, tmp_path, scheme, size):
    with visit(browser, f"{url}#t=0.02", size, scheme) as page:
        assert [address for address in page.asked if not address.startswith("data:")] == [url]
        pixels = picture(page, tmp_path / "canvas.png")
        ground = pixels[2, 2]
        assert ground.mean() > 0.8 if scheme == "light" else ground.mean() < 0.2
        # the line spans the canvas, in many colours
        drawn = abs(pixels - ground).max(axis=2) > 0.25
        columns = drawn.any(axis=0)
        assert columns.mean() > 0.4
        assert len(np.unique((pixels[drawn] * 15).round(), axis=0)) > 20
        # nothing sticks out sideways
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= size[0]


def test_the_room_stands_on_a_bed_with_a_profile(browser, tmp_path):
    scene = "[seabed]\nheight = -4\nprofile = { x = [0, 20, 40, 60], depth = [0, 0, 12, 12] }"
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, scene=scene)
    page_of = write_recorded(path, tmp_path / "page.html").as_uri()
    with visit(browser, f"{page_of}#t=0&view=side") as page:
        drawn_anew(page)
        labels = {
            label.inner_text().replace("−", "-"): label.bounding_box()
            for label in page.locator(".labels span").all()
            if label.is_visible()
        }
        at = {text: (box["x"], box["y"]) for text, box in labels.items()}
    # numbers stand on the bed: as deep at 10 m as at 20 m, and 12 m deeper from 40 m on
    metre = (at["50"][0] - at["10"][0]) / 40.0
    assert at["20"][1] == pytest.approx(at["10"][1], abs=0.5 * metre)
    assert at["60"][1] == pytest.approx(at["50"][1], abs=0.5 * metre)
    assert at["50"][1] - at["10"][1] == pytest.approx(12.0 * metre, rel=0.05)


@pytest.mark.parametrize("view", ["zzz", "constructor"])
def test_an_address_with_a_view_that_there_is_not_shows_the_scene(browser, tmp_path, view):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4)
    page_of = write_recorded(path, tmp_path / "page.html").as_uri()
    with visit(browser, f"{page_of}#t=0&view={view}") as page:
        drawn_anew(page)  # it is ready and has complained of nothing
        assert any(label.is_visible() for label in page.locator(".labels span").all())


def test_a_scene_at_rest_has_no_time_to_run_through(browser, tmp_path):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, times=np.zeros(1))
    with visit(browser, write_recorded(path, tmp_path / "page.html").as_uri()) as page:
        assert page.locator(".transport").is_hidden()
        assert page.get_by_label("History", exact=True).is_hidden()
        assert page.get_by_label("Quantity along the line", exact=True).is_visible()
        assert text_of(page, "lines/rope/length") != ""


def test_scrubbing_shows_the_file_s_values(browser, url, file):
    with open_result(file) as result:
        position = result.line("rope").position(2)
        speed = np.linalg.norm(result.line("rope").velocity(2), axis=-1).max(axis=1)
        kinetic = result.energy("kinetic", 2)
    length = np.linalg.norm(np.diff(position, axis=1), axis=-1).sum(axis=1)
    with visit(browser, f"{url}#t=0&run=2") as page:
        for sample in (0, 60, 137, 200):
            page.locator("input.track").fill(str(sample))
            assert text_of(page, "time") == f"{sample:.1f} ms"
            assert value_of(page, "lines/rope/length") == pytest.approx(length[sample], abs=0.00501)
            assert value_of(page, "lines/rope/peak_speed") == pytest.approx(
                speed[sample], abs=0.0501
            )
        page.locator("summary", has_text="Energies now").click()
        row = page.locator("tr", has=page.locator('[data-key="energy/kinetic"]'))
        assert row.locator(".unit").inner_text() == "MJ"  # of the largest of all runs
        assert value_of(page, "energy/kinetic") == pytest.approx(kinetic[200] / 1e6, abs=0.000501)


def test_a_link_s_run_is_that_of_the_file(browser, file, tmp_path, monkeypatch):
    monkeypatch.setattr(recorded, "MOST_RUNS", 3)
    few = write_recorded(file, tmp_path / "few.html").as_uri()  # runs 0, 4 and 7 of 8
    with open_result(file) as result:
        label = result.label(4)
    with visit(browser, f"{few}#t=0&run=4&with=7") as page:
        assert page.locator(".few").all_inner_texts() == ["3 of 8 runs"]
        assert page.get_by_label("Run", exact=True).locator("option:checked").inner_text() == label
    with visit(browser, f"{few}#t=0&run=1") as page:
        assert page.locator(".few").all_inner_texts() == ["3 of 8 runs", "no run 1 here"]


def test_runs_are_chosen_and_laid_over_each_other(browser, url, tmp_path):
    with visit(browser, f"{url}#t=0.03") as page:
        before = picture(page, tmp_path / "one.png")
        # 45 kN and 180 kN pull 3 % and 12 % into the line; both leave at T/(m c)
        page.get_by_label("pretension", exact=True).select_option("180 kN")
        assert text_of(page, "rope.end/exact_peak_end_speed") == "98.242 m/s"
        page.get_by_label("Run laid over it").select_option("0")
        drawn_anew(page)
        assert value_of(page, "lines/rope/peak_speed+") == pytest.approx(24.56, abs=0.2)
        both = picture(page, tmp_path / "both.png")
        orange = (abs(both - np.array([0xD5, 0x5E, 0x00]) / 255).max(axis=2) < 0.25).sum()
        assert orange > 50 > (abs(before - np.array([0xD5, 0x5E, 0]) / 255).max(axis=2) < 0.2).sum()


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_ships_and_cargo_are_solid(browser, transfer, tmp_path, size):
    url = write_recorded(transfer, tmp_path / "page.html").as_uri()
    with visit(browser, f"{url}#t=2&view=front", size) as page:
        drawn_anew(page)
        pixels = picture(page, tmp_path / "canvas.png")
    # seen from the front the ship is 12 m broad and 8 m high, of a scene 50 m and more across
    body = abs(pixels - np.array([0x8B, 0x99, 0xA3]) / 255).max(axis=2) < 0.006
    # letters have pixels of that colour too, but few in a row
    columns, rows = body.sum(axis=0) > 8, body.sum(axis=1) > 8
    assert 0.05 < columns.mean() < 0.4
    assert rows.any()
    # 12 by 8 m, rolled by 0.1 sin(2 pi 2 / 5) = 0.059: 12.4 by 8.7; with some of its side
    wide, high = np.ptp(np.flatnonzero(columns)), np.ptp(np.flatnonzero(rows))
    assert 1.3 < wide / high < 2.5, wide / high


def test_a_run_that_failed_says_so(browser, url):
    with visit(browser, f"{url}#t=0.15&run=5") as page:
        assert page.locator(".note").inner_text() == "diverged at 100 ms: too much strain"
        assert text_of(page, "lines/rope/length") == "–"


def test_it_plays_in_slow_motion_and_says_how_slow(browser, url):
    with visit(browser, f"{url}#t=0") as page:
        assert page.locator(".pace").inner_text() == "50× slower"
        page.get_by_label("Slower").click()
        assert page.locator(".pace").inner_text() == "100× slower"
        page.get_by_label("Play").click()
        page.wait_for_function(
            "parseFloat(document.querySelector('[data-key=time]').textContent) > 1"
        )
        page.keyboard.press("Escape")
        page.get_by_label("Pause").click()
        now = text_of(page, "time")
        drawn_anew(page)
        assert text_of(page, "time") == now


def test_dragging_in_the_history_moves_the_time(browser, url):
    with visit(browser, f"{url}#t=0") as page:
        plot = page.get_by_label("History of a quantity")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        page.mouse.move(box["x"] + 60, box["y"] + 40)
        page.mouse.down()
        # the plot's own margins: 50 px on the left, 10 on the right
        page.mouse.move(box["x"] + 50 + (box["width"] - 60) / 2, box["y"] + 40, steps=3)
        page.mouse.up()
        assert float(text_of(page, "time").split()[0]) == pytest.approx(100, abs=1)
