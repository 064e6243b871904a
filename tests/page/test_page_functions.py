"""Functions of the page that draw what is partly missing, run in a browser."""

from math import isnan, nan

import pytest
from page.browser import chromium


@pytest.fixture(scope="module")
def run(pytestconfig):
    source = (pytestconfig.rootpath / "web/src/between.js").read_text().replace("export ", "")
    with chromium() as browser:
        page = browser.new_page()
        yield lambda asked: page.evaluate(f"() => {{ {source}\n return {asked}; }}")


@pytest.mark.parametrize(
    ("first", "last", "share", "seen"),
    [
        (1.0, 3.0, 0.25, 1.5),
        (1.0, nan, 0.0, 1.0),  # a run that has gone wrong before the later frame
        (1.0, nan, 0.9, 1.0),
        (1.0, nan, 1.0, nan),
        (nan, nan, 0.5, nan),
        (1.0, 3.0, 1.0, 3.0),
    ],
)
def test_a_run_that_went_wrong_is_shown_until_then(run, first, last, share, seen):
    found = run(f"between({first}, {last}, {share})".replace("nan", "NaN"))
    assert found == seen or (isnan(found) and isnan(seen))


@pytest.mark.parametrize(
    ("nodes", "end"),
    [
        ([[0, 0, 0], [1, 2, 3]], [1, 2, 3]),
        ([[0, 0, 0], [1, 2, 3], [nan] * 3, [nan] * 3], [1, 2, 3]),
        ([[nan] * 3, [nan] * 3], [nan] * 3),
    ],
)
def test_the_end_of_a_line_is_its_last_node_in_that_run(run, nodes, end):
    flat = str([x for node in nodes for x in node]).replace("nan", "NaN")
    found = list(run(f"Array.from(endOf(new Float64Array({flat})))"))
    assert found == pytest.approx(end, nan_ok=True)
