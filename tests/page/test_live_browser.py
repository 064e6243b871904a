"""The live page in a browser: a dragged slider leads to the closed form's value."""

import signal
from contextlib import contextmanager

import numpy as np
import pytest
from command_line import ROOT, address, process
from highline_numbers import FROM_LENGTH
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


@pytest.fixture(scope="module")
def mooring(browser, tmp_path_factory):
    """The page of a chain over a bed."""
    pytest.importorskip("uvicorn")
    scene = ROOT / "configs" / "peers" / "chain-mooring.toml"
    coarse = ("--set", "lines.chain.segments=20")
    with process(tmp_path_factory.mktemp("bed"), "view", scene, "--no-browser", *coarse) as started:
        yield address(started)
        started.send_signal(signal.SIGINT)
        started.communicate(timeout=60)


@contextmanager
def live(browser, url, size=LAPTOP):
    with visit(browser, url, size) as page:
        page.wait_for_selector("html[data-answers]", timeout=30_000)
        yield page


def told(page, key):
    return float(page.locator(f'[data-key="{key}"][data-si]').get_attribute("data-si"))


def room(page):
    """How many things the room around the lines is made of."""
    return int(page.evaluate("document.documentElement.dataset.room"))


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
        page.get_by_label("distance of the cargo from the sending end, typed").fill("30")
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


def test_the_legend_ends_where_the_read_outs_do(browser, url):
    with live(browser, url) as page:
        page.get_by_label("Stage").select_option("stabilisation-length")
        settled(page)
        page.get_by_label("length of the highline, typed").fill("63.34896")
        settled(page)
        # the closed form's ends: in the middles of its first and last parts it is 3 N less and more
        assert page.locator(".legend .ends span").last.inner_text() == "4.002"
        assert text_of(page, "F_TA") == "4.002"
        assert text_of(page, "F_TB") == "3.362"
        answer = page.evaluate(
            """async () => (await fetch("solve", { method: "POST",
                headers: { "Content-Type": "application/json" },
                body: JSON.stringify({ model: "stabilisation-length", values: { length: 63.34896 } }) })
            ).json()"""
        )
        (line,) = answer["lines"]
        assert line["ends"] == pytest.approx(FROM_LENGTH[2:4], rel=1e-8)


def test_what_another_stage_showed_does_not_stay_while_one_is_worked_out(browser, url):
    with live(browser, url) as page:
        settled(page)
        about = page.locator(".remark"), page.locator(".key.second"), page.locator(".equations")
        assert [one.is_visible() for one in about] == [True, True, True]
        assert about[0].inner_text() == "closed form of an inextensible line"
        page.route("**/solve", lambda route: None)  # it never answers
        page.get_by_label("Stage").select_option("scene")
        page.wait_for_function("document.querySelector('.note').textContent.startsWith('Working')")
        assert [one.is_visible() for one in about] == [False, False, False]
        assert page.locator("td.value").count() == 0


def test_a_stage_does_not_wait_for_an_answer_about_another(browser, url):
    held = []
    with live(browser, url) as page:

        def answer(route):
            if '"scene"' in route.request.post_data:
                held.append(route)  # as while its first shape is compiled
            else:
                route.continue_()

        page.route("**/solve", answer)
        page.get_by_label("Stage").select_option("scene")
        page.wait_for_function("() => document.documentElement.dataset.asking === 'yes'")
        page.get_by_label("Stage").select_option("adjustment")
        page.wait_for_selector("[data-key][data-si]", timeout=10_000)
        assert page.evaluate("() => document.documentElement.dataset.asking") == "no"
        assert len(held) == 1


def test_the_unit_of_an_axis_keeps_off_its_numbers(browser, url, tmp_path):
    with live(browser, url) as page:
        page.get_by_label("Stage").select_option("adjustment")
        settled(page)
        page.get_by_label("tension at the sending end, typed").fill("127")
        settled(page)
        drawn_anew(page)
        pixels = picture(page, tmp_path / "plot.png", ".plothost canvas")
    # from the left: a blank rim, the unit, a gap of some pixels, the numbers
    inked = (abs(pixels - pixels[0, 0]).max(axis=2) > 0.1)[:, :60].any(axis=0)
    first = np.flatnonzero(inked)[0]
    end = first + np.flatnonzero(~inked[first:])[0]
    following = end + np.flatnonzero(inked[end:])[0]
    assert end < 20
    assert following - end >= 4


@pytest.mark.parametrize(
    ("scene", "key", "values"),
    [
        pytest.param("url", "length", (80, 62.5), id="floor"),
        pytest.param("mooring", "seabed.height", (-75, -90, -60), id="bed", marks=pytest.mark.slow),
    ],
)
def test_an_old_room_does_not_stay(browser, request, tmp_path, scene, key, values):
    with live(browser, request.getfixturevalue(scene)) as page:
        settled(page)
        page.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))")

        def seen(name):
            drawn_anew(page)
            page.wait_for_timeout(800)  # edges are smoothed once it stands still
            return picture(page, tmp_path / f"{name}.png")

        before, things = seen("before"), room(page)
        assert things > 0
        for value in values:
            page.locator(f'.control:has(input[data-key="{key}"]) input.field').fill(str(value))
            settled(page)
            assert room(page) == things
        page.get_by_role("button", name="Reset").click()
        settled(page)
        assert room(page) == things
        assert abs(seen("after") - before).max() < 0.01


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
