"""The live page in a browser: a dragged slider leads to the closed form's value."""

import signal
from contextlib import contextmanager

import numpy as np
import pytest
from command_line import address, process
from page.browser import LAPTOP, PHONE, chromium, drawn_anew, picture, text_of, visit
from page.test_live_page import HIGHLINE

from benchmarks.page import moved
from lumpedcable.exact import loaded_from_length, loaded_from_tension
from lumpedcable.scene import load_study


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def url(browser, tmp_path_factory):
    pytest.importorskip("uvicorn")
    folder = tmp_path_factory.mktemp("live")
    (folder / "scene.toml").write_text(HIGHLINE)
    with process(folder, "view", "scene.toml", "--no-browser") as started:
        yield address(started)
        started.send_signal(signal.SIGINT)
        _, err = started.communicate(timeout=60)
    assert (started.returncode, err) == (0, "")


@contextmanager
def live(browser, url, size=LAPTOP):
    with visit(browser, url, size) as page:
        page.wait_for_selector("html[data-answers]", timeout=30_000)
        yield page


def told(page, key):
    return float(page.locator(f'[data-key="{key}"][data-si]').get_attribute("data-si"))


def settled(page):
    """Wait until every question has its answer."""
    page.wait_for_function("document.documentElement.dataset.asking === 'no'")


def test_a_dragged_slider_leads_to_the_closed_form(browser, url):
    with live(browser, url) as page:
        slider = page.locator('input.slide[data-key="place"]')
        box = slider.bounding_box()
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + box["width"] / 2, middle)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.25 * box["width"], middle, steps=6)
        page.mouse.up()
        settled(page)
        place = float(slider.input_value())
        assert 10 < place < 20
        exact = loaded_from_length(60, 16, 40, 20e3, place, 62.5)
        assert told(page, "F_TA") == pytest.approx(float(exact.tension_a), rel=1e-9)
        assert told(page, "F_H") == pytest.approx(float(exact.horizontal), rel=1e-9)
        # as it is written, in kN
        assert text_of(page, "F_TA") == f"{float(exact.tension_a) / 1e3:.2f}"
        equation = page.locator(".equations code").first.inner_text()
        scale = equation.removeprefix("z = ").partition(" [cosh(")[0]
        assert float(scale) == pytest.approx(float(exact.horizontal) / 40, rel=1e-6)


def test_many_moves_lead_to_the_closed_form_of_the_last(browser, url):
    with live(browser, url) as page:
        # how quick they are is for python -m benchmarks page to tell
        assert len(moved(page, "delivery", "place", 12)) == 12
        place = float(page.locator('input.slide[data-key="place"]').input_value())
        exact = loaded_from_length(60, 16, 40, 20e3, place, 62.5)
        assert told(page, "F_TA") == pytest.approx(float(exact.tension_a), rel=1e-9)


def test_stages_numbers_and_faults(browser, url, tmp_path):
    with live(browser, url) as page:
        page.get_by_label("Stage").select_option("delivery-tension")
        settled(page)
        field = page.get_by_label("tension at the sending end, typed")
        field.fill("60")
        settled(page)
        exact = loaded_from_tension(60, 16, 40, 20e3, 30, 60e3)
        assert told(page, "F_TB") == pytest.approx(float(exact.tension_b), rel=1e-9)
        field.fill("1")
        settled(page)
        assert "or more, the least that holds this line" in page.locator(".note").inner_text()
        page.get_by_role("button", name="Reset").click()
        settled(page)
        assert page.locator(".note").inner_text() == ""
        assert told(page, "F_TA") == pytest.approx(80e3, rel=1e-9)
        field.fill("70")
        settled(page)
        with page.expect_download() as waiting:
            page.get_by_role("button", name="Save as TOML").click()
        saved = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(saved)
    assert saved.name == "scene-changed.toml"
    scene = load_study(saved).scene
    assert scene.title == "Highline: delivery at constant tension"
    assert scene.bodies["cargo"].mass == pytest.approx(20e3 / 9.81)


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_it_draws(browser, url, tmp_path, size):
    with live(browser, url, size) as page:
        drawn_anew(page)
        pixels = picture(page, tmp_path / "canvas.png")
        drawn = abs(pixels - pixels[2, 2]).max(axis=2) > 0.25
        assert drawn.any(axis=0).mean() > 0.4
        # it hangs from high on the left to low on the right: columns of drawn pixels go down
        middle = pixels[
            70:-90, pixels.shape[1] // 4 : -pixels.shape[1] // 4
        ]  # no buttons, no legend
        line = abs(middle - pixels[2, 2]).max(axis=2) > 0.4
        columns = np.flatnonzero(line.any(axis=0))
        tops = [np.flatnonzero(line[:, c]).min() for c in columns]
        assert tops[-len(tops) // 10] > tops[len(tops) // 10]
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
