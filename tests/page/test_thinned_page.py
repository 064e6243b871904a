"""A page of more saved times than it has room for: what is extreme stays, and it says how many."""

import h5py
import numpy as np
import pytest
import synthetic_result
from page.browser import chromium, drawn_anew, picture, visit
from page.test_recorded_page import unpacked

from lumpedcable.page import recorded as module
from lumpedcable.page.open import write_recorded
from lumpedcable.page.recorded import recorded
from lumpedcable.page.thinned import with_peaks
from lumpedcable.results import open_result
from lumpedcable.results.spread import even

PEAK = 77  # of 201 times


@pytest.fixture
def peaked(tmp_path, monkeypatch):
    """A file with a peak of one time, and one of another in the tension at an end; room for 50 times."""
    monkeypatch.setattr(module, "MOST_TIMES", 50)
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4, failed=(3,))
    with h5py.File(path, "r+") as changed:
        changed["energy/kinetic"][:, PEAK] = 5e9
        like = changed["energy/kinetic"]
        tension = changed.create_dataset("lines/rope/end_tension", data=np.full(like.shape, 1e3))
        tension[4, PEAK + 2] = 4e5
        tension.attrs["units"] = "N"
        for k, dim in enumerate(like.dims):
            tension.dims[k].label = dim.label
            for scale in dim.values():
                tension.dims[k].attach_scale(scale)
    assert PEAK not in even(201, 50)
    return path


def test_extremes_survive(peaked):
    head = recorded(peaked)
    block = head.pack.text()
    time = unpacked(block, head["time"]["data"])
    assert 40 < len(time) <= 50
    assert head["times_in_file"] == 201
    found = {h["key"]: h for h in head["histories"]}
    with open_result(peaked) as result:
        whole, energy = result.time, result.energy("kinetic")
    told = unpacked(block, found["energy/kinetic"]["extremes"])
    assert told.shape == (8, 2, 2)
    # of the run that went wrong half-way, what came before
    assert told[:, 1] == pytest.approx(np.array([[whole[PEAK], 5e9]] * 8))
    assert told[:, 0, 1] == pytest.approx(np.nanmin(energy, axis=1))
    kinetic = found["energy/kinetic"]
    assert kinetic["top"] / kinetic["factor"] == pytest.approx(5e9)
    # the largest tension is a time of the page, so that it can be looked at
    tension = unpacked(block, found["lines/rope/end_tension"]["data"])
    assert tension[4].max() == 4e5
    assert time[tension[4].argmax()] == pytest.approx(whole[PEAK + 2])


def test_nothing_is_left_out_where_there_is_room(peaked, monkeypatch):
    monkeypatch.setattr(module, "MOST_TIMES", 201)
    head = recorded(peaked)
    assert head["time"]["data"]["shape"] == [201]
    assert not any("extremes" in history for history in head["histories"])


def test_more_peaks_than_room_are_an_even_choice():
    histories = [np.eye(100)[k] for k in range(0, 100, 2)]
    kept = with_peaks(100, 20, [*histories, np.full(100, np.nan)])
    assert len(kept) <= 20
    assert {0, 98, 99} <= set(kept)


def test_the_page_says_so_and_draws_the_peak(peaked, tmp_path):
    url = write_recorded(peaked, tmp_path / "page.html").as_uri()
    (count,) = recorded(peaked)["time"]["data"]["shape"]
    with chromium() as browser, visit(browser, f"{url}#t=0&run=2") as page:
        assert page.locator(".few").inner_text() == f"{count} of 201 times"
        page.get_by_label("History", exact=True).select_option("energy/kinetic")
        drawn_anew(page)
        plot = page.get_by_label("History of a quantity")
        plot.screenshot(path=str(tmp_path / "plot.png"))
        pixels = picture(page, tmp_path / "plot.png", 'canvas[aria-label="History of a quantity"]')
    blue = abs(pixels - np.array([0x00, 0x72, 0xB2]) / 255).max(axis=2) < 0.25
    columns = np.flatnonzero(blue.any(axis=0))
    tops = np.array([np.flatnonzero(blue[:, c]).min() for c in columns]) / pixels.shape[0]
    # all but the peak lies at the bottom; it reaches the top at 77 of 200 of the way
    assert np.median(tops) > 0.65
    assert tops.min() < 0.15
    peak = (columns[tops.argmin()] - columns[0]) / (columns[-1] - columns[0])
    assert peak == pytest.approx(PEAK / 200, abs=0.02)
