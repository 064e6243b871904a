"""The page of a results file: what it holds, how it is written and served."""

import base64
import gzip
import hashlib
import json
import re
import signal
import urllib.error
import urllib.request

import h5py
import numpy as np
import pytest
import synthetic_result
from command_line import ROOT, address, process, refused, say

from lumpedcable.page import recorded as module
from lumpedcable.page.curves import sag
from lumpedcable.page.document import document
from lumpedcable.page.recorded import recorded
from lumpedcable.results import (
    Coordinate,
    ResultError,
    ResultWriter,
    Variable,
    open_result,
)


def unpacked(block, how):
    """An array of the page, decoded as the page does it."""
    raw = gzip.decompress(base64.b64decode(block))
    kind = {"f4": "<f4", "i2": "<i2"}[how["kind"]]
    count = int(np.prod(how["shape"]))
    array = np.frombuffer(raw, kind, count, how["start"]).reshape(how["shape"])
    if how["kind"] == "f4":
        return array
    return np.where(array == -32768, np.nan, array * how["step"] + how["middle"])


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    return synthetic_result.snapback(folder / "r.h5", segments=20, sag=2.0, failed=(3,), padded=2)


def test_fields_are_the_file_s_to_what_a_screen_shows(file):
    head = recorded(file)
    block = head.pack.text()
    (line,) = head["lines"]
    with open_result(file) as result:
        position, tension = result.line("rope").position(), result.line("rope").tension()
    pairs = [(line["position"][k], position[..., k]) for k in range(3)]
    for how, right in (*pairs, (line["tension"], tension)):
        told = unpacked(block, how)
        # what no run has is not there
        right, padding = right[..., : told.shape[2]], right[..., told.shape[2] :]
        assert padding.size
        assert np.isnan(padding).all()
        assert told.shape == right.shape
        # half a step of 64000 over the range, and float32's rounding in the file
        room = np.nanmax(right) - np.nanmin(right)
        assert np.nanmax(abs(told - right)) <= room / 128_000 + 1e-6
        assert (np.isnan(told) == np.isnan(right)).all()
    assert np.isnan(right[3, 150]).all()  # a run that failed half-way


def test_read_outs_are_the_file_s_own_numbers(file):
    head = recorded(file)
    block = head.pack.text()
    found = {h["key"]: unpacked(block, h["data"]) for h in head["histories"]}
    with open_result(file) as result:
        place = result.line("rope").position()[..., :21, :]
        kinetic = result.energy("kinetic")
    # z = -4 a (x - x^2), x in lengths, up to x = X: a X^2 below its chord, at x = X/2, from which
    # the nearest of the nodes is at most X/40 away; where it curves upwards, nothing is below
    a = 2.0 * np.cos(2 * np.pi * synthetic_result.TIMES / 0.3)
    exact = a * (place[0, :, -1, 0] / synthetic_result.LENGTH) ** 2
    off = found["lines/rope/sag"][0] - np.clip(exact, 0, None)
    assert off.max() < 1e-6
    assert off.min() > -2.0 * 4 / 40**2 * 1.1
    chords = np.sqrt((np.diff(place, axis=2) ** 2).sum(-1)).sum(-1)
    assert np.allclose(found["lines/rope/length"], chords, rtol=1e-6, equal_nan=True)
    assert np.allclose(found["energy/kinetic"], kinetic, rtol=1e-6, equal_nan=True)


@pytest.fixture
def blown(tmp_path):
    """A file whose run 3 has numbers beyond all bounds from half-way on, when it went wrong."""
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=20, sag=2.0, failed=(3,))
    with h5py.File(path, "r+") as changed:
        for name in ("lines/rope/position", "lines/rope/tension", "lines/rope/velocity"):
            changed[name][3, 100:] = 1e35
        changed["energy/kinetic"][3, 100:] = 1e125
        changed["energy/strain"][3, 100:] = np.inf
    return path


def test_a_run_that_blew_up_leaves_the_others_as_they_are(blown):
    head = recorded(blown)
    block = head.pack.text()
    (line,) = head["lines"]
    with open_result(blown) as result:
        position, tension = result.line("rope").position(), result.line("rope").tension()
        energies = {f"energy/{term}": result.energy(term) for term in ("kinetic", "strain")}
    good = np.ones(tension.shape[:2], bool)
    good[3, 100:] = False
    pairs = [(line["position"][k], position[..., k]) for k in range(3)]
    for how, right in (*pairs, (line["tension"], tension)):
        told, room = unpacked(block, how), np.ptp(right[good])
        assert abs(told - right)[good].max() <= room / 128_000 + 1e-6
        assert np.isnan(told[~good]).all()
    for history in head["histories"]:
        found = unpacked(block, history["data"])
        assert np.isfinite(found[good]).all()
        assert np.isnan(found[~good]).all()
        if history["key"] in energies:
            assert np.allclose(found[good], energies[history["key"]][good], rtol=1e-6)
        assert history["top"] < 1e6


def test_a_run_that_has_stopped_stays_where_it_lies(tmp_path):
    times = np.linspace(0.0, 4.0, 5)
    position = np.zeros((2, 5, 3))
    position[:, :, 0] = times
    position[1, 3:, 0] = 2.5  # where it stopped
    variables = [
        Variable("bodies/ship/position", ("run", "time", "xyz"), "f8", "m"),
        Variable("bodies/ship/attitude", ("run", "time", "xyz"), "f8", "rad"),
        Variable("lines/cable/position", ("run", "time", "node", "xyz"), "f8", "m"),
        Variable("lines/cable/payout", ("run", "time"), "f8", "m"),
        Variable("lines/cable/velocity", ("run", "time", "node", "xyz"), "f8", "m/s"),
        Variable("summary/stop_time", ("run",), "f8", "s"),
    ]
    dims = {"run": 2, "time": 5, "xyz": 3, "lines/cable/node": 2, "lines/cable/segment": 1}
    known = {"time": Coordinate(times, "s")}
    for name, places in (("node", [0.0, 9.0]), ("segment", [4.5])):
        path = f"lines/cable/unstretched_{'position' if name == 'node' else name}"
        known[path] = Coordinate(places, "m", "", (name,))
    with ResultWriter(
        tmp_path / "r.h5", dims=dims, variables=variables, coordinates=known, attributes={}
    ) as writer:
        writer.write("bodies/ship/position", position)
        writer.write("bodies/ship/attitude", 0.0 * position)
        writer.write("lines/cable/position", np.stack([position, position + 9.0], axis=2))
        writer.write("lines/cable/payout", position[..., 0])
        writer.write("lines/cable/velocity", np.full((2, 5, 2, 3), 0.39 / np.sqrt(3.0)))
        writer.write("summary/stop_time", [np.nan, 2.6])
        path = writer.finish()
    head = recorded(path)
    block = head.pack.text()
    (line,), (ship,) = head["lines"], head["bodies"]
    payout = next(h["data"] for h in head["histories"] if h["key"] == "lines/cable/payout")
    seen = (ship["position"][0], payout, line["position"][0])
    for told in (unpacked(block, how) for how in seen):
        x = told[1, :, 0] if told.ndim == 3 else told[1]
        assert x == pytest.approx([0.0, 1.0, 2.0, 2.5, 2.5], abs=1e-3)
    # it has a speed until the first time after its stop, which is of the stop, and none as it lies
    fastest = next(h["data"] for h in head["histories"] if h["key"] == "lines/cable/peak_speed")
    for told in (unpacked(block, fastest), unpacked(block, line["speed"])[..., 0]):
        assert told[0] == pytest.approx([0.39] * 5)
        assert told[1] == pytest.approx([0.39] * 4 + [np.nan], nan_ok=True)


def test_runs_and_numbers_are_told(file):
    head = recorded(file)
    assert head["runs"][1]["label"] == "pretension 45 kN, break time 50 ms"
    assert head["runs"][3]["status"] == "diverged at 100 ms"
    assert head["runs"][3]["message"] == "too much strain"
    numbers = {o["key"]: o["texts"] for o in head["outputs"]}
    # T/(m c), with c = sqrt(EA/m) = 818.7 m/s
    assert numbers["rope.end/exact_peak_end_speed"][0] == "24.56 m/s"
    assert numbers["run/energy_closure"][0] == "1·10⁻⁶"


def test_a_large_file_is_thinned(file, monkeypatch):
    monkeypatch.setattr(module, "MOST_RUNS", 3)
    monkeypatch.setattr(module, "MOST_NODES", 7)
    monkeypatch.setattr(module, "MOST_TIMES", 50)
    monkeypatch.setattr(module, "MOST_DRAWN", 3 * 5 * 7 * 25)
    head = recorded(file)
    block = head.pack.text()
    (line,) = head["lines"]
    assert [run["number"] for run in head["runs"]] == [0, 4, 7]
    assert (head["runs_in_file"], head["first"]) == (8, 0)
    assert line["position"][0]["shape"] == [3, 25, 7]
    assert line["tension"]["shape"] == [3, 25, 6]
    time = unpacked(block, head["time"]["data"])
    assert (time[0], time[-1], len(time)) == (0.0, pytest.approx(0.2), 50)
    assert (head["frames"][0], head["frames"][-1]) == (0, 49)
    # the places of the segments kept lie between those of the nodes kept
    place, middle = unpacked(block, line["place"]), unpacked(block, line["middle"])
    inside = np.isfinite(place[:, 1:])
    assert (place[:, :-1] < middle)[inside].all()
    assert (middle < place[:, 1:])[inside].all()
    asked = recorded(file, 5)  # is shown, and comes first
    assert [run["number"] for run in asked["runs"]] == [0, 5, 7]
    assert asked["first"] == 1
    with pytest.raises(ResultError, match="expected a run from 0 to 7, found 8"):
        recorded(file, 8)


def test_runs_of_few_nodes_are_drawn_to_their_ends(tmp_path, monkeypatch):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=60, sag=2.0)
    few = 11  # nodes of run 2, as a sweep over segments leaves them
    with h5py.File(path, "r+") as changed:
        rope = changed["lines/rope"]
        for name, count in (("position", few), ("velocity", few), ("tension", few - 1)):
            rope[name][2, :, count:] = np.nan
        for name, count in (("unstretched_position", few), ("unstretched_segment", few - 1)):
            places = np.tile(rope[name][()], (8, 1))
            places[2, count:] = np.nan
            del rope[name]
            rope[name] = places
    monkeypatch.setattr(module, "MOST_NODES", 13)
    head = recorded(path)
    (line,) = head["lines"]
    block = head.pack.text()
    places, middles = unpacked(block, line["place"]), unpacked(block, line["middle"])
    assert places.shape == (8, 13)
    for run, count in ((0, 13), (2, few)):
        drawn = places[run][np.isfinite(places[run])]
        with open_result(path) as result:
            own = result.line("rope").unstretched_position(run)
        own = own[np.isfinite(own)]
        assert len(drawn) == count
        assert drawn[[0, -1]] == pytest.approx(own[[0, -1]])
        assert np.isfinite(middles[run]).sum() == count - 1
        for k in range(3):
            assert (np.isfinite(unpacked(block, line["position"][k])[run, 0]).sum()) == count


@pytest.mark.parametrize(
    ("scene", "surface", "bed"),
    [
        ("[water]\ndensity = 1025.0", None, None),
        ("[water]\ndensity = 1025.0\n[seabed]\nheight = -20.0", 0.0, -20.0),
        ('[water.current]\nprofile = "power"\nsurface = 2.5', 2.5, None),
        ("[seabed]\nheight = -3", None, -3.0),
        ("[seabed]\nheight = -3\nprofile = { x = [0, 'far'], depth = [1, 2] }", None, None),
        ("not TOML", None, None),
    ],
)
def test_surface_and_bed_are_the_scene_s(tmp_path, scene, surface, bed):
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, scene=scene)
    around = recorded(path)["surroundings"][0]
    assert (around["surface"], around["bed"]) == (surface, bed)


def test_a_bed_with_a_profile_is_a_curve(tmp_path):
    x, depth = [0.0, 10.0, 20.0, 40.0], [1.0, 2.0, 8.0, 10.0]
    scene = f"[seabed]\nheight = -3\nprofile = {{ x = {x}, depth = {depth} }}"
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, scene=scene)
    bed = recorded(path)["surroundings"][0]["bed"]
    places, heights = np.array(bed["x"]), np.array(bed["z"])
    assert heights[np.isin(places, x)] == pytest.approx(-3.0 - np.array(depth), abs=1e-12)
    # it falls from point to point, and as the first and the last two beyond them
    assert (np.diff(places) > 0.0).all()
    assert (np.diff(heights) < 0.0).all()
    assert bed["slopes"] == pytest.approx([-0.1, -0.1])
    # Hermite's cubic at the middle of 10 to 20 m: the mean, and (left - right) slope by an eighth;
    # there these are harmonic means of 0.1 and 0.6 (equal steps), and of 0.6 and 0.1 with 4/9 and 5/9
    left, right = -2.0 / (1 / 0.1 + 1 / 0.6), -1.0 / ((4 / 9) / 0.1 + (5 / 9) / 0.6)
    middle = 0.5 * (-5.0 - 11.0) + 10.0 / 8.0 * (left - right)
    assert np.interp(15.0, places, heights) == pytest.approx(middle, abs=1e-12)


def test_a_title_cannot_break_out_of_the_page():
    # nor take the place of what is put in after it, nor open what no script ends
    text = "</script><b>& <!--blob--> <!--head--> <!-- <script> ]]>"
    head = {"kind": "recorded", "title": "</script><b>&", "value": float("nan"), "file": text}
    page = document(head, "AAAA")
    script = re.search(r'<script id="head"[^>]*>(.*?)</script>', page, re.DOTALL)[1]
    assert json.loads(script) == {**head, "value": None}
    assert "<" not in script
    assert re.search(r'<script id="blob"[^>]*>AAAA</script>', page)
    assert "<title>&lt;/script&gt;&lt;b&gt;&amp;</title>" in page


def test_the_page_is_built_from_its_sources():
    web = ROOT / "web"
    names = ["index.html", "package-lock.json", "vite.config.js"]
    names += [f"src/{path.name}" for path in (web / "src").iterdir()]
    digest = hashlib.sha256(b"".join((web / name).read_bytes() for name in sorted(names)))
    page = (ROOT / "lumpedcable" / "page" / "page.html").read_text()
    built = re.search(r'<meta name="sources" content="(\w+)">', page)[1]
    assert built == digest.hexdigest(), "run: cd web && npm ci && npm run build"


# --- commands ------------------------------------------------------------------------------------


def test_the_page_is_written_whole(file, tmp_path):
    said = say(tmp_path, "view", file, "-o", "out/page.html")
    assert (said.code, said.out, said.err) == (0, "out/page.html\n", "")
    text = (tmp_path / "out" / "page.html").read_text()
    assert len(text) < 3e6
    # nothing is fetched: no element has an address outside
    assert re.findall(r'(?:src|href)="(?!data:)[^"]*"', text) == []
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["page.html"]


def test_what_cannot_be_shown_is_told(file, tmp_path):
    assert "no such file: none.h5" in refused(tmp_path, "view", "none.h5", "-o", "p.html")
    (tmp_path / "page").mkdir()
    assert "found the folder page" in refused(tmp_path, "view", file, "-o", "page")
    said = refused(tmp_path, "view", file, "-o", file)
    assert "expected another file than the results" in said
    blind = synthetic_result.snapback(tmp_path / "blind.h5", segments=4, fields=("tension",))
    assert "holds no positions to draw" in refused(tmp_path, "view", blind, "-o", "p.html")


def test_the_page_is_served_to_this_machine_alone(file, tmp_path):
    pytest.importorskip("uvicorn")
    with process(tmp_path, "view", file, "--no-browser") as started:
        url = address(started)
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url)
        with urllib.request.urlopen(url, timeout=20) as answer:
            assert b"Linear line parting" in answer.read()
        request = urllib.request.Request(url, headers={"Host": "elsewhere.example"})
        with pytest.raises(urllib.error.HTTPError) as refusal:
            urllib.request.urlopen(request, timeout=20)
        assert refusal.value.code == 400
        refusal.value.close()
        taken = refused(tmp_path, "view", file, "--no-browser", "--port", url.split(":")[2][:-1])
        assert "cannot be had" in taken
        started.send_signal(signal.SIGINT)
        _, err = started.communicate(timeout=60)
    assert (started.returncode, err) == (0, "")


def test_sag_is_that_of_what_hangs_below_the_chord():
    # 1 m below the middle of a level chord of 4 m; then a steep one that swings out beyond its end
    hangs = [[0, 0, 0], [1, 0, -0.6], [2, 0, -1], [4, 0, 0]]
    steep = [[0, 0, 0], [0.005, 0, -1], [1.5, 0, -1], [0.01, 0, -2.2]]
    found = sag(np.array([hangs, steep], float))
    # of the steep one its second node is 0.1 m above the chord, -1.1 there, and no node is below
    np.testing.assert_allclose(found, [1.0, 0.0], atol=1e-12)
