"""How long after a slider has moved the live page shows the new shape, in a real browser.

From the input event until the pixels of the frame with the answer can be read back: the question to
the program on 127.0.0.1, its statics, the answer, the picture. Drawn by the processor where there is
no graphics card. "Answer" is the part until the answer has come.
"""

from __future__ import annotations

import math
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.machine import UnableError

ROOT = Path(__file__).parents[1]
CONFIGS = ROOT / "configs"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# as it starts by itself, but that it may draw WebGL without a graphics card
OPTIONS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"]
# scene, stage, slider
CASES = (
    ("highline/delivery.toml", "erection", "time"),
    ("highline/delivery.toml", "stabilisation-length", "length"),
    ("highline/delivery.toml", "adjustment", "tension"),
    ("highline/delivery.toml", "delivery", "place"),
    ("highline/delivery.toml", "delivery-tension", "place"),
    ("highline/delivery.toml", "unloading", "drop"),
    ("highline/delivery.toml", "withdrawal", "time"),
    ("sagged-cable.toml", "scene", "lines.cable.length"),
)
MOVES = 40
# one move to a value: ms until the frame with the answer is there, and until the answer has come
MOVE = """([slider, value]) => new Promise((done) => {
    const begun = performance.now();
    const pen = document.querySelector(".stage canvas").getContext("webgl2");
    const drawn = () => {
        pen.readPixels(0, 0, 1, 1, pen.RGBA, pen.UNSIGNED_BYTE, new Uint8Array(4));
        done([performance.now() - begun, Number(document.documentElement.dataset.took)]);
    };
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    const look = () => (document.documentElement.dataset.asking === "yes" ? setTimeout(look, 0)
        : requestAnimationFrame(() => setTimeout(drawn, 0)));
    look();
})"""


def moved(page: Any, stage: str, key: str, moves: int = MOVES) -> list[tuple[float, float]]:
    """Times (ms) of some moves of a slider over the middle of its range, the first left out.

    Each until the frame with the answer is there, and until the answer has come.
    """
    box = page.get_by_label("Stage", exact=True)
    if box.count():
        box.select_option(stage)
    page.wait_for_function("document.documentElement.dataset.asking === 'no'", timeout=120_000)
    slider = page.locator(f'input.slide[data-key="{key}"]')
    low, high = (float(slider.get_attribute(side)) for side in ("min", "max"))
    found = []
    for k in range(moves + 1):
        value = low + (high - low) * (0.45 + 0.1 * k / moves)
        found.append(tuple(slider.evaluate("(e, [code, v]) => eval(code)([e, v])", [MOVE, value])))
    return found[1:]


def run(quick: bool) -> list[dict[str, Any]]:
    """Every case: its times (ms) in short."""
    from playwright.sync_api import sync_playwright

    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise UnableError(f"no browser: none of {', '.join(BROWSERS)} is installed")
    found = []
    with sync_playwright() as started, tempfile.TemporaryDirectory() as folder:
        chromium = started.chromium.launch(executable_path=browser, args=OPTIONS)
        for scene in dict.fromkeys(case[0] for case in CASES):
            command = [sys.executable, "-m", "lumpedcable", "view", str(CONFIGS / scene)]
            server = subprocess.Popen(
                [*command, "--no-browser"], stdout=subprocess.PIPE, text=True, cwd=folder
            )
            assert server.stdout is not None
            page = chromium.new_page(viewport={"width": 1366, "height": 768})
            page.goto(server.stdout.readline().split()[0])
            page.wait_for_selector("html[data-answers]", timeout=120_000)
            for _, stage, key in (case for case in CASES if case[0] == scene):
                times = moved(page, stage, key, 8 if quick else MOVES)
                row = {"scene": scene, "stage": stage, "slider": key}
                found.append({**row, **in_short(*map(sorted, zip(*times, strict=True)))})
            page.close()
            server.send_signal(signal.SIGINT)
            server.wait()
        chromium.close()
    return found


def in_short(whole: list[float], answers: list[float]) -> dict[str, float]:
    """The shares of sorted times that the table shows (ms); at p % lies the time of p % of the moves."""
    return {
        "least": whole[0],
        "median": statistics.median(whole),
        "most": whole[math.ceil(0.95 * len(whole)) - 1],
        "answer": statistics.median(answers),
    }


def table(data: list[dict[str, Any]]) -> str:
    """The table of the report."""
    rows = [
        f"| `configs/{row['scene']}` | {row['stage']} | {row['slider']} | {row['least']:.0f} "
        f"| {row['median']:.0f} | {row['most']:.0f} | {row['answer']:.0f} |"
        for row in data
    ]
    head = [
        "| scene | stage | slider | least, ms | median, ms | 95 %, ms | answer, median, ms |",
        "|---|---|---|---|---|---|---|",
    ]
    return "\n".join([*head, *rows])


if __name__ == "__main__":
    print(table(run("--quick" in sys.argv)))
