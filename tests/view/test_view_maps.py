"""Maps of a study: cells stand where their values do and show the largest or earliest run."""

import h5py
import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from lumpedcable.results import ResultError, ResultWriter, Variable, open_result, sweep_coordinates
from lumpedcable.view import plot_result
from lumpedcable.view.maps import ENOUGH, map_figures

TENSIONS, TIMES, DRAGS = np.array([1e3, 2e3, 3e3]), np.array([1e-3, 1e-2, 1e-1]), np.arange(4.0)
KEYS = ("lines.rope.end.held.pretension", "events.break.time", "lines.rope.drag.tangential")


def study(path, tensions, times, drags):
    """Speeds T/1000 + t - drag, which is largest where the drag is least; arrivals the other way."""
    speed = tensions / 1e3 + times - drags
    with ResultWriter(
        path,
        dims={"run": len(speed), "time": 2},
        variables=[
            Variable(
                "status", ("run",), "i1", attributes={"flag_values": [0], "flag_meanings": "ok"}
            ),
            Variable("summary/rope.end/peak_end_speed", ("run",), units="m/s", long_name="speed"),
            Variable("summary/rope.end/front_arrival", ("run",), units="s", long_name="arrival"),
            Variable(
                "summary/gap",
                ("run",),
                units="m",
                long_name="least gap",
                attributes={"extreme": "least"},
            ),
        ],
        coordinates=sweep_coordinates(
            list(zip(KEYS, ("N", "s", ""), (tensions, times, drags), strict=True))
        ),
    ) as writer:
        writer.write("status", np.zeros(len(speed), int))
        writer.write("summary/rope.end/peak_end_speed", speed)
        writer.write("summary/rope.end/front_arrival", -speed)
        writer.write("summary/gap", speed + 1.0)
    return path


def maps(path):
    """By name: the panels of each figure, as (x label, y label, cells)."""
    found = {}
    with open_result(path) as result:
        for name, draw in map_figures(result):
            found[name] = []
            for ax in draw().axes:
                meshes = [c for c in ax.collections if isinstance(c, QuadMesh)]
                if meshes and ax.get_label() != "<colorbar>":
                    cells = np.asarray(meshes[0].get_array()).reshape(
                        meshes[0]._coordinates.shape[0] - 1, -1
                    )
                    found[name].append(
                        (ax.get_xlabel(), ax.get_ylabel(), cells, meshes[0]._coordinates)
                    )
    return found


def test_a_cell_is_the_largest_or_earliest_of_its_runs(tmp_path):
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    shuffled = np.random.default_rng(1).permutation(36)
    path = study(tmp_path / "a.h5", *(g[shuffled] for g in grid))
    found = maps(path)
    assert set(found) == {"map_peak_end_speed", "map_front_arrival", "map_gap"}
    speed = found["map_peak_end_speed"]
    assert [(x, y) for x, y, _, _ in speed] == [
        ("pretension (kN)", "break time (ms)"),
        ("pretension (kN)", "drag tangential (-)"),
        ("break time (ms)", "drag tangential (-)"),
    ]
    np.testing.assert_allclose(speed[0][2], [[t + s for t in (1, 2, 3)] for s in TIMES])
    np.testing.assert_allclose(speed[2][2], [[3 + s - d for s in TIMES] for d in DRAGS])
    # of a measure the least, which has no history here: that of the most drag
    np.testing.assert_allclose(
        found["map_gap"][0][2], [[t + s - 3.0 + 1.0 for t in (1, 2, 3)] for s in TIMES]
    )
    # seconds here, milliseconds there; the earliest of minus the speeds is minus the largest
    early = found["map_front_arrival"][0][2]
    np.testing.assert_allclose(early, -speed[0][2] * (early[0, 0] / -speed[0][2][0, 0]))


def test_cells_stand_where_their_values_do(tmp_path):
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    corners = maps(study(tmp_path / "a.h5", *grid))["map_peak_end_speed"][0][3]
    np.testing.assert_allclose(corners[0, :, 0], [0.5, 1.5, 2.5, 3.5])
    np.testing.assert_allclose(corners[:, 0, 1], 10 ** np.array([-0.5, 0.5, 1.5, 2.5]))


def figure_of(path, name="map_peak_end_speed"):
    with open_result(path) as result:
        figure = dict(map_figures(result))[name]()
    figure.canvas.draw()
    return figure


def small_print(figure):
    return figure.get_supxlabel()


@pytest.mark.parametrize(("times", "shown"), [
    (np.geomspace(2e-3, 6e-2, 41), {"3", "10", "20", "40"}),
    (np.array([1e-3, 1e-2, 1e-1]), {"1", "10", "100"}),
])  # fmt: skip
def test_axes_of_ratios_have_plain_numbers(tmp_path, times, shown):
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, times, DRAGS[:1], indexing="ij")]
    ax = figure_of(study(tmp_path / "a.h5", *grid)).axes[0]
    assert ax.get_ylabel() == "break time (ms)"
    assert ax.get_yscale() == "log"
    ticks = ax.get_yticklabels() + ax.get_yticklabels(minor=True)
    texts = {text.get_text() for text in ticks} - {""}
    assert all(float(text) > 0 for text in texts)  # no mathtext
    assert shown <= texts


def test_draws_about_a_mean_have_an_even_axis(tmp_path):
    rng = np.random.default_rng(3)
    drags = np.abs(rng.normal(0.01, 0.003, 3000))
    drags[0] = 2e-4  # one near zero makes the range long, not the draws even in their logarithms
    tensions, times = rng.uniform(1e3, 4e3, 3000), np.exp(rng.uniform(0.0, 4.0, 3000)) * 1e-3
    axes = figure_of(study(tmp_path / "a.h5", tensions, times, drags)).axes
    assert [(ax.get_xscale(), ax.get_yscale()) for ax in axes[:3]] == [
        ("linear", "log"),
        ("linear", "linear"),
        ("log", "linear"),
    ]
    # side by side there is room for few numbers
    ticks = axes[2].get_xticklabels() + axes[2].get_xticklabels(minor=True)
    texts = {text.get_text() for text in ticks} - {""}
    assert {"2", "5", "10", "20", "50"} <= texts <= {"1", "2", "5", "10", "20", "50", "100"}


def test_white_cells_are_explained_where_there_are_any(tmp_path):
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    assert "White" not in small_print(figure_of(study(tmp_path / "a.h5", *grid)))
    some = [g[(grid[0] < TENSIONS[2]) | (grid[1] < TIMES[2])] for g in grid]
    assert "White cells: no run in them." in small_print(
        figure_of(study(tmp_path / "b.h5", *some))
    ).replace("\n", " ")
    path = study(tmp_path / "c.h5", *grid)
    with h5py.File(path, "r+") as file:
        file["summary/rope.end/peak_end_speed"][:4] = np.nan  # of one pair of the first two
    told = small_print(figure_of(path)).replace("\n", " ")
    assert "White cells: none with a number in them." in told


def test_draws_are_put_into_bins(tmp_path):
    rng = np.random.default_rng(2)
    tensions, times, drags = (rng.uniform(1.0, 4.0, 3000) for _ in range(3))
    found = maps(study(tmp_path / "a.h5", tensions * 1e3, times, drags))["map_peak_end_speed"]
    cells = found[0][2]
    assert cells.shape == (12, 12)
    # the largest of some twenty runs: near T + t - 1, the least drag
    middle = np.linspace(1.0, 4.0, 25)[1::2]
    assert cells == pytest.approx(middle[None] + middle[:, None] - 1.0, abs=1.5)
    assert np.corrcoef(cells.ravel(), (middle[None] + middle[:, None]).ravel())[0, 1] > 0.97


@pytest.mark.slow
def test_few_values_make_no_map_and_maps_are_files(tmp_path):
    two = study(tmp_path / "two.h5", np.array([1e3, 2e3]), np.array([1.0, 2.0]), np.zeros(2))
    with open_result(two) as result:
        assert list(map_figures(result)) == []
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    made = plot_result(study(tmp_path / "a.h5", *grid), tmp_path)
    # and of a measure, which has no history here, its bars
    maps = ["map_gap.png", "map_front_arrival.png", "map_peak_end_speed.png"]
    assert [p.name for p in made] == [*maps, "bars_gap.png"]


def test_how_far_a_body_came_is_a_map_of_enough_draws(tmp_path):
    """The distance is the speed's square over the friction, whatever the third number is."""
    rng = np.random.default_rng(3)
    for count in (ENOUGH - 1, ENOUGH):
        speed, friction = rng.uniform(2.0, 5.0, count), rng.uniform(0.3, 0.7, count)
        path = tmp_path / f"{count}.h5"
        keys = [("bodies.ship.velocity.0", "m/s", speed), ("bodies.anchor.friction", "", friction)]
        with ResultWriter(
            path,
            dims={"run": count, "time": 2},
            variables=[
                Variable(
                    "status", ("run",), "i1", attributes={"flag_values": [0], "flag_meanings": "ok"}
                ),
                Variable("summary/stop_distance", ("run",), units="m", long_name="way"),
            ],
            coordinates=sweep_coordinates(keys),
        ) as writer:
            writer.write("status", np.zeros(count, int))
            writer.write("summary/stop_distance", speed**2 / friction)
    with pytest.raises(ResultError, match=f"two swept numbers of 3 values .* {ENOUGH} draws"):
        plot_result(tmp_path / f"{ENOUGH - 1}.h5", tmp_path)
    assert [p.name for p in plot_result(path, tmp_path)] == ["map_stop_distance.png"]
    ((_, _, cells, _),) = maps(path)["map_stop_distance"]
    assert np.nanmax(cells) == pytest.approx(np.max(speed**2 / friction))
    assert cells.shape == (4, 4)  # two draws or more a cell, on average


def test_cells_with_runs_without_a_number_are_hatched(tmp_path):
    """The largest of the others says nothing of a run that did not come so far."""
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    path = study(tmp_path / "a.h5", *grid)
    with h5py.File(path, "r+") as file:
        file["summary/rope.end/front_arrival"][5] = np.nan  # of 1 kN, 10 ms and the drag of 1
    with open_result(path) as result:
        figures = {name: draw() for name, draw in map_figures(result)}
    marked = [
        [(*patch.get_xy(), patch.get_hatch()) for patch in ax.patches]
        for ax in figures["map_front_arrival"].axes[:3]
    ]
    edge = np.log(1e1), np.log(1e2)
    ((x, y, hatch),) = marked[0]
    assert (x, hatch) == (0.5, "////")
    assert y == pytest.approx(np.exp(sum(edge) / 2 - (edge[1] - edge[0])), rel=1e-9)
    assert [len(each) for each in marked] == [1, 1, 1]
    assert "Hatched: with runs that saw no front as well, 1 of 36 in all." in words(
        figures["map_front_arrival"]
    )
    assert not any(ax.patches for ax in figures["map_peak_end_speed"].axes[:3])


def test_cells_with_runs_that_are_not_computed_yet_are_not_hatched(tmp_path):
    grid = [g.ravel() for g in np.meshgrid(TENSIONS, TIMES, DRAGS, indexing="ij")]
    path = study(tmp_path / "a.h5", *grid)
    with h5py.File(path, "r+") as file:
        file["status"].attrs["flag_values"] = np.array([0, 1], "i1")
        file["status"].attrs["flag_meanings"] = "ok interrupted"
        file["status"][5] = 1
        file["summary/rope.end/front_arrival"][5] = np.nan
    with open_result(path) as result:
        figure = dict(map_figures(result))["map_front_arrival"]()
    assert not any(ax.patches for ax in figure.axes[:3])
    assert "Hatched" not in words(figure)


def words(figure):
    return " ".join(text.get_text().replace("\n", " ") for text in figure.texts)
