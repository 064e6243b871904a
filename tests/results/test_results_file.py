"""Writing and reading back: values, names, units, and what other programs see."""

import re

import h5py
import numpy as np
import pytest
import xarray as xr
from synthetic_result import BREAK_TIMES, LENGTH, PRETENSIONS, TIMES, snapback, wave

from lumpedcable.results import (
    Coordinate,
    ResultError,
    ResultWriter,
    Variable,
    axis_names,
    describe,
    lines,
    open_result,
    sweep_coordinates,
)
from lumpedcable.results.human import quantity, size
from lumpedcable.results.schema import axes_words, axis_words


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return snapback(tmp_path_factory.mktemp("results") / "sweep.h5", failed=(3,))


def test_fields_come_back_as_the_closed_form_says(path):
    run = 5  # third pretension, second break time
    pretension, break_time = PRETENSIONS[2], BREAK_TIMES[1]
    with open_result(path) as result:
        line = result.line("rope")
        place = line.unstretched_segment(run)
        tension = line.tension(run)
        assert tension.dtype == np.float32
        expected, _ = wave(place, result.time, pretension, break_time)
        np.testing.assert_allclose(tension, expected, atol=pretension * 2**-23)
        _, speed = wave(line.unstretched_position(run), TIMES, pretension, break_time)
        velocity = line.velocity(run, time=slice(20, 30))
        np.testing.assert_allclose(velocity[..., 0], speed[20:30], atol=abs(speed).max() * 2**-23)
        assert not velocity[..., 1:].any()
        assert line.position(time=0).shape == (8, 61, 3)
        assert line.nodes == 61
        assert line.fields == ["position", "strain", "tension", "velocity"]
        assert result.energy("kinetic").shape == (8, 201)
        assert result.energy("kinetic", run).shape == (201,)


def test_sweep_axes_and_labels(path):
    with open_result(path) as result:
        assert result.runs == 8
        assert [(axis.name, axis.key, axis.unit) for axis in result.axes] == [
            ("held_pretension", "lines.rope.end.held.pretension", "N"),
            ("break_time", "events.break.time", "s"),
        ]
        assert list(result.axes[0].values) == [45e3, 45e3, 180e3, 180e3, 315e3, 315e3, 45e4, 45e4]
        assert result.label(0) == "pretension 45 kN, break time 5 ms"
        assert result.label(7) == "pretension 450 kN, break time 50 ms"


def test_statuses_and_summary(path):
    with open_result(path) as result:
        assert result.status == ["ok"] * 3 + ["diverged"] + ["ok"] * 4
        assert result.status_time[3] == TIMES[100]
        assert np.isnan(np.delete(result.status_time, 3)).all()
        assert result.status_message[3] == "too much strain"
        summary = result.summary()
        assert set(summary) == {"run", "rope.end"}
        assert list(summary["run"]["energy_closure"]) == [1e-6] * 8
        strain = summary["rope.end"]["static_strain"]
        np.testing.assert_allclose(strain, result.axes[0].values / 1.5e6)
        kept = result.summary_attributes("rope.end", "exact_front_arrival")
        assert (kept["units"], kept["holds"]) == ("s", "instantaneous break, no drag")
        kept = result.summary_attributes("rope.end", "reference_book_front_arrival")
        assert kept["source"] == "A book"
        assert result.summary_attributes("run", "energy_closure")["units"] == "1"


def test_attributes_survive_in_their_types(path):
    with open_result(path) as result:
        known = result.attributes
        assert known["complete"] is True
        assert known["overrides"] == ["break.time=50 ms"]
        assert known["versions"] == {"jax": "0.7.2"}
        assert known["dimensions"]["lines/rope/node"] == 61
        assert known["step"] == 1.2e-5
        assert known["schema_version"] == "1"


def test_a_long_scene_is_kept_verbatim(tmp_path):
    scene = '# a comment with 9.81 m/s² and a "quote"\n' * 5000  # over the 64 kB of an attribute
    file = snapback(tmp_path / "a.h5", pretensions=(45e3,), break_times=(5e-3,), scene=scene)
    with open_result(file) as result:
        assert result.scene_text == scene


def test_xarray_opens_the_tree_with_names_units_and_coordinates(path):
    with xr.open_datatree(path, engine="h5netcdf") as tree:
        assert list(tree["xyz"].values) == ["x", "y", "z"]
        assert tree["time"].attrs["units"] == "s"
        assert {"held_pretension", "break_time"} <= set(tree.coords)
        tension = tree["lines/rope/tension"]
        assert tension.dims == ("run", "time", "segment")
        assert tension.attrs == {"units": "N", "long_name": "tension"}
        early = tension.sel(time=0.0)  # the root's times are inherited
        np.testing.assert_allclose(early.isel(run=0).values, PRETENSIONS[0])
        position = tree["lines/rope/position"]
        assert position.dims == ("run", "time", "node", "xyz")
        assert position.sel(xyz="x", time=0.0, node=0).values.tolist() == [0.0] * 8
        assert tree["energy/kinetic"].attrs["units"] == "J"
        assert tree["summary/rope.end/exact_front_arrival"].dims == ("run",)
        assert tree["status_message"].values[3] == "too much strain"
        assert tree["status"].attrs["flag_meanings"] == "pending ok diverged"


def test_xarray_opens_one_line(path):
    with xr.open_dataset(path, group="lines/rope", engine="h5netcdf") as line:
        assert line["position"].dims == ("run", "time", "node", "xyz")
        assert line["unstretched_position"].attrs["units"] == "m"
        assert "unstretched_position" in line["velocity"].coords
        assert "unstretched_segment" in line["tension"].coords
        assert line["unstretched_position"].values[-1] == LENGTH


def test_every_dataset_has_units_a_name_and_scales(path):
    with h5py.File(path) as file:
        datasets = []
        file.visititems(
            lambda _, item: datasets.append(item) if isinstance(item, h5py.Dataset) else None
        )
        assert len(datasets) > 20
        for dataset in datasets:
            assert dataset.attrs["units"]
            assert dataset.attrs["long_name"]
            if not dataset.is_scale:
                assert all(len(dim) == 1 for dim in dataset.dims), dataset.name
        scale = file["lines/rope/position"].dims[2][0]
        assert scale.name == "/lines/rope/node"


def test_lines_that_differ_between_runs(tmp_path):
    """Unstretched places along `run` too, with the short run padded by NaN."""
    places = np.array([[0.0, 1.0, 2.0], [0.0, 2.0, np.nan]])
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"run": 2, "time": 1, "lines/rope/node": 3},
        variables=[Variable("lines/rope/speed", ("run", "time", "node"), "f8", "m/s")],
        coordinates={
            "time": Coordinate([0.0], "s"),
            "lines/rope/unstretched_position": Coordinate(places, "m", dims=("run", "node")),
        },
    ) as writer:
        writer.write("lines/rope/speed", [[1.0, 2.0, 3.0]], run=0)
    with open_result(tmp_path / "a.h5") as result:
        line = result.line("rope")
        np.testing.assert_array_equal(line.unstretched_position(1), places[1])
        np.testing.assert_array_equal(line.field("speed", 0), [[1, 2, 3]])
        assert np.isnan(line.field("speed", 1)).all()  # never written
        assert list(result.written) == [1, 0]


def test_a_dimension_is_looked_up_from_the_inside_out(tmp_path):
    with ResultWriter(
        tmp_path / "a.h5",
        dims={"node": 2, "lines/rope/node": 3, "run": 1, "time": 1},
        variables=[Variable(f"{group}v", ("node",)) for group in ("", "lines/", "lines/rope/")],
    ) as writer:
        writer.write("v", [1.0, 2.0])
        writer.write("lines/v", [1.0, 2.0])
        writer.write("lines/rope/v", [1.0, 2.0, 3.0])
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["lines/v"].dims[0][0].name == "/node"
        assert file["lines/rope/v"].dims[0][0].name == "/lines/rope/node"


def test_unknown_names_are_answered_with_the_nearest(path):
    with open_result(path) as result:
        with pytest.raises(ResultError, match=r"no line 'rop'; nearest: rope"):
            result.line("rop")
        with pytest.raises(ResultError, match=r"no energy term 'kinetc'; nearest: kinetic"):
            result.energy("kinetc")
        with pytest.raises(ResultError, match="no curvature"):
            result.line("rope").field("curvature")
        with pytest.raises(ResultError, match="no part"):
            result.line("rope").tension(8)


def test_describe_tells_all(path):
    text = describe(path)
    for part in (
        "Linear line parting",
        "complete",
        "lines.rope.end.held.pretension: 4 values, 45 kN, 180 kN, 315 kN, 450 kN",
        "events.break.time: 2 values, 5 ms, 50 ms",
        "rope: 61 nodes, 60 m unstretched; position, strain, tension, velocity",
        "0 s to 200 ms every 1 ms, 201 saved",
        "leapfrog, step 12 µs, waves corrected, float64",
        "7 ok, 1 diverged",
        "diverged at 100 ms (pretension 180 kN, break time 50 ms): too much strain",
        "lumpedcable 0.1.0, jax 0.7.2",
        "break.time=50 ms",
        size(path.stat().st_size),
    ):
        assert part in text
    assert "incomplete" not in text


@pytest.mark.parametrize("at_once", [2**20, 8])  # all runs in a block, or a run in each
def test_describe_tells_the_lengths_of_the_parts_of_a_line(tmp_path, monkeypatch, at_once):
    # 60 m cut at 20, 35 and 30 m: parts of 20 to 35 and of 25 to 40 m, least and largest in no outer run
    monkeypatch.setattr(lines, "_AT_ONCE", at_once)
    cuts = (30.0, 20.0, 35.0, 30.0)
    nodes = {
        "rope-1": np.array([[0.0, c / 2, c, np.nan] for c in cuts]),
        "rope-2": np.array([[c, (c + 60) / 2, 60.0, np.nan] for c in cuts]),
        "winched": np.full((4, 4), np.nan),  # found when a run starts, and none has
    }
    nodes["rope-2"][3] = np.nan
    with ResultWriter(
        tmp_path / "cut.h5",
        dims={"run": 4, "time": 2, **{f"lines/{name}/node": 4 for name in nodes}},
        variables=[Variable(f"lines/{name}/u", ("run", "time", "node"), "f4") for name in nodes],
        coordinates={
            f"lines/{name}/unstretched_position": Coordinate(places, "m", dims=("run", "node"))
            for name, places in nodes.items()
        },
    ):
        pass
    text = describe(tmp_path / "cut.h5")
    assert "rope-1: 4 nodes, 20 m to 35 m unstretched; u" in text
    assert "rope-2: 4 nodes, 25 m to 40 m unstretched; u" in text
    assert "winched: 4 nodes, unstretched length not yet known; u" in text


def test_describe_tells_of_failures_behind_runs_that_are_not_begun(tmp_path):
    many = np.linspace(45e3, 450e3, 14)
    path = snapback(
        tmp_path / "half.h5", pretensions=many, break_times=(5e-3,), segments=4, times=TIMES[:4],
        fields=("tension",), failed=(12, 13),
    )  # fmt: skip
    with h5py.File(path, "r+") as file:
        file["status"][:12] = 0  # as an unwritten one reads
    text = describe(path)
    for run in (12, 13):
        assert re.search(rf"^run {run} .*too much strain$", text, re.MULTILINE)
    assert "more" not in text


@pytest.mark.parametrize(
    ("keys", "names"),
    [
        (["events.break.time"], ["break_time"]),
        (["gravity"], ["gravity"]),
        (
            ["lines.a.end.held.pretension", "lines.b.end.held.pretension"],
            ["a_end_held_pretension", "b_end_held_pretension"],
        ),
        (["lines.a.mass", "bodies.a.mass"], ["lines_a_mass", "bodies_a_mass"]),
        (["time"], ["time_"]),  # taken by the saved times
        (["a_b.c", "a.b_c"], ["a_b_c", "a_b_c_"]),
    ],
)
def test_names_of_swept_keys_are_short_and_differ(keys, names):
    assert axis_names(keys) == names


def test_names_of_swept_keys_leave_those_that_are_taken():
    keys = ["lines.a.end.held.pretension", "break.time"]
    assert axis_names(keys, {"held_pretension"}) == ["end_held_pretension", "break_time"]
    assert list(sweep_coordinates([("gravity", "m/s2", [9.8])], {"gravity"})) == ["gravity_"]


def test_sweep_coordinates_carry_key_unit_and_order():
    made = sweep_coordinates([("water.density", "kg/m3", [1.0]), ("solver.courant", "", [0.9])])
    assert list(made) == ["water_density", "solver_courant"]
    assert [c.units for c in made.values()] == ["kg/m3", "1"]
    assert [c.long_name for c in made.values()] == ["water density", "courant"]
    assert made["solver_courant"].attributes == {"key": "solver.courant", "axis": 1}
    with pytest.raises(ValueError, match="must differ"):
        axis_names(["gravity", "gravity"])


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("lines.rope.end.held.pretension", "pretension"),
        ("events.break.time", "break time"),
        ("lines.rope.added_mass.normal", "added mass normal"),
        ("gravity", "gravity"),
    ],
)
def test_words_of_swept_keys(key, words):
    assert axis_words(key) == words


def test_words_of_two_ships_swept_alike_say_which():
    keys = [f"bodies.{ship}.motion.heave.amplitude" for ship in ("supply", "receiver")]
    assert axes_words([*keys, "gravity"]) == [
        "supply heave amplitude", "receiver heave amplitude", "gravity"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (45e3, "N", "45 kN"),
        (999.9999999999, "N", "1 kN"),
        (-2.5e6, "N", "-2.5 MN"),
        (0.005, "s", "5 ms"),
        (2000.0, "s", "2000 s"),
        (60.0, "m", "60 m"),
        (0.05, "m", "50 mm"),
        (1e-9, "m", "1 nm"),
        (1e-12, "J", "0.001 nJ"),
        (0.0, "s", "0 s"),
        (1025.0, "kg/m3", "1025 kg/m3"),
        (2000.0, "N s", "2 kN s"),
        (2000.0, "m/s", "2000 m/s"),
        (0.5235987755982988, "rad", "30 deg"),
        (0.3, "", "0.3"),
        (0.3, "1", "0.3"),
    ],
)
def test_quantities_read_like_speech(value, unit, text):
    assert quantity(value, unit) == text


def test_sizes_of_files():
    assert [size(n) for n in (7, 3_240_000, 12e12)] == ["7 B", "3.24 MB", "12 TB"]
