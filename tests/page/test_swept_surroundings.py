"""Water, bed and posts that a sweep changes are those of the run that is shown."""

import pytest
from page.browser import chromium, visit

from lumpedcable.page.filmed import beside_lines
from lumpedcable.page.open import write_recorded
from lumpedcable.page.recorded import recorded
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study

SCENE = """
gravity = 9.81
[water]
density = 1025
[seabed]
height = -30
stiffness = "20 kPa"
[materials.rope]
law = "linear"
EA = "1 MN"
[bodies.ship]
position = [0, 0, 0]
points = { post = [0, 0, 5] }
size = [20, 8, 6]
motion = { heave = { amplitude = 1, period = 8 } }
[sea]
height = 1
period = 6
flow = {}
[lines.rope]
material = "rope"
length = 30
segments = 6
mass = 1
diameter = 0.03
start = "ship.post"
end = { fixed = [25, 0, 0] }
[[sweep.zip]]
"sea.flow.surface" = [0, 12]
"seabed.height" = [-30, -18]
"bodies.ship.points.post.2" = [5, 9]
[output]
duration = 0.2
every = 0.1
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    (folder / "scene.toml").write_text(SCENE)
    run_study(load_study(folder / "scene.toml"), folder / "swept.h5")
    return folder / "swept.h5"


@pytest.mark.slow
def test_a_page_has_those_of_every_run(file):
    head = recorded(file)
    around = [(one["surface"], one["bed"]) for one in head["surroundings"]]
    assert around == [(0.0, -30.0), (12.0, -18.0)]
    (ship,) = head["bodies"]
    assert ship["size"] == 2 * [[20.0, 8.0, 6.0]]
    assert ship["points"] == [[[0.0, 0.0, 5.0]], [[0.0, 0.0, 9.0]]]


def test_a_film_has_those_of_its_run(file):
    with open_result(file) as result:
        tops = [beside_lines(result, run).faces[0][0].reshape(-1, 3) for run in (0, 1)]
    # a post up to where the line begins
    assert [top[:, 2].max() for top in tops] == pytest.approx([5.0, 9.0])


def test_a_browser_changes_the_room_with_the_run(file, tmp_path):
    page = write_recorded(file, tmp_path / "page.html").as_uri()
    seen = []
    with chromium() as browser:
        for run in (0, 1):
            with visit(browser, f"{page}#run={run}&t=0") as shown:
                water = shown.locator("html").get_attribute("data-water").split(",")
                box = shown.locator("html").get_attribute("data-box").split(",")
                seen.append((float(water[2]), float(box[2])))
    (low, deep), (high, shallow) = seen
    assert low == pytest.approx(0.0, abs=0.6)
    assert high == pytest.approx(12.0, abs=0.6)
    assert deep == pytest.approx(-30.0, abs=1.5)
    assert shallow == pytest.approx(-18.0, abs=1.5)
