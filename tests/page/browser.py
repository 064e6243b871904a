"""A headless Chromium for the pages, or the reason why there is none."""

import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchmarks.page import BROWSERS, OPTIONS

LAPTOP, PHONE = (1366, 768), (390, 844)


@contextmanager
def chromium():
    """A browser; the test is skipped where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=found, args=OPTIONS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def visit(browser, url, size=LAPTOP, scheme="light"):
    """A page that is ready; it must have loaded nothing else and complained of nothing."""
    context = browser.new_context(
        viewport=dict(zip(("width", "height"), size, strict=True)), color_scheme=scheme
    )
    page, complaints, asked = context.new_page(), [], []

    def hear(message):
        # reading pixels back, as a screenshot does, is slow; Chromium warns of it
        if message.type in ("error", "warning") and "GPU stall" not in message.text:
            complaints.append(message.text)

    page.on("console", hear)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(url)
    page.wait_for_selector("html[data-ready=yes]", timeout=20_000)
    page.asked = asked
    try:
        yield page
        assert not complaints, complaints
    finally:
        context.close()


def drawn_anew(page):
    """Wait until the page has drawn what it was told before: it does so in its next frame."""
    page.evaluate(
        "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )


def text_of(page, key):
    """What a read-out says."""
    return page.locator(f'[data-key="{key}"]').inner_text().replace("−", "-")


def value_of(page, key):
    return float(text_of(page, key))


def picture(page, file: Path, what=".stage canvas"):
    """The pixels of an element as an array (height, width, 3)."""
    import matplotlib.image

    page.locator(what).screenshot(path=str(file))
    return matplotlib.image.imread(file)[..., :3]
