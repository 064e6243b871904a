"""The package from Python: what the command line does, as objects."""

import copy
import json
import os
import pickle
import shutil
import subprocess
import sys
from functools import partial

import good_scenes
import h5py
import numpy as np
import pytest
import xarray
from command_line import ROOT, SMALL

import lumpedcable as lc
from lumpedcable import api


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("api")
    good_scenes.write(folder, SMALL)
    return folder / "scene.toml"


@pytest.fixture(scope="module")
def result(scene):
    return lc.run(scene, {"break.time": "1 ms"}, pretension=[45e3, np.float64(90e3)])


def test_importing_it_loads_nothing_heavy():
    code = "import sys, lumpedcable; print({'jax', 'numpy', 'pydantic', 'h5py'} & set(sys.modules))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "set()"


def test_all_names_are_there():
    assert all(getattr(lc, name) is not None for name in lc.__all__)
    with pytest.raises(AttributeError, match="no attribute 'runn'"):
        lc.runn  # noqa: B018


def test_lines_are_labelled_arrays(result):
    assert (result.lines, result.status) == (["rope"], ["ok", "ok"])
    assert result.labels == ["pretension 45 kN", "pretension 90 kN"]
    rope = result.line("rope")
    assert rope.tension.dims == ("run", "time", "segment")
    assert rope.tension.attrs["units"] == "N"
    # before the break the line carries what pulls at it
    start = rope.tension.sel(time=0.0).isel(segment=-1)
    # in the middle of the last segment, where its weight bends it a little
    assert start.values == pytest.approx([45e3, 90e3], rel=1e-7)
    assert start.held_pretension.values.tolist() == [45e3, 90e3]
    assert result.dataset.held_pretension.attrs["units"] == "N"
    assert set(result.energy) >= {"kinetic", "strain", "residual"}
    assert result.summary("rope.end").static_tension.values == pytest.approx([45e3, 90e3])
    assert "energy_closure" in result.summary()
    assert result.summary().held_pretension.values.tolist() == [45e3, 90e3]
    along = rope.position.sel(xyz="x")
    np.testing.assert_array_equal(along, rope.position.isel(xyz=0))
    # arrays that are in use do not keep others from reading
    assert lc.open(result.path).labels == result.labels


@pytest.mark.parametrize("other", [
    h5py.File, partial(h5py.File, locking=False), partial(xarray.open_datatree, engine="h5netcdf"),
])  # fmt: skip
def test_whoever_has_it_open_does_not_keep_us_from_reading(result, tmp_path, other):
    path = shutil.copy(result.path, tmp_path / "r.h5")
    with other(path):
        assert lc.open(path).line("rope").tension.shape[0] == 2


def test_we_do_not_keep_others_from_reading(result, tmp_path):
    path = shutil.copy(result.path, tmp_path / "r.h5")
    tension = lc.open(path).line("rope").tension  # which is not yet read
    with h5py.File(path) as file, xarray.open_datatree(path, engine="h5netcdf") as tree:
        assert file["lines/rope/tension"].shape == tension.shape
        assert tree["lines/rope"].tension.shape == tension.shape


def test_it_is_drawn_and_shown(result, tmp_path):
    figures = result.plot()
    assert {"tension", "end_speed", "xt", "energy"} <= set(figures)
    assert figures["energy"].axes
    assert figures._repr_html_().count('src="data:image/png;base64,iVBOR') == len(figures)
    made = result.plot(tmp_path / "pictures", formats="png")  # one for several
    assert {path.stem for path in made} == set(figures)
    page = result.view()
    assert page._repr_html_().startswith('<iframe srcdoc="&lt;!doctype html&gt;')
    assert page.save(tmp_path / "page.html").read_text() == page.text
    assert [p.name for p in result.export("csv", tmp_path / "r.csv")] == ["r.csv"]


def test_a_saved_result_stays(scene, tmp_path):
    made = lc.run(scene, pretension=np.array([45e3, 50e3]))
    first = made.path
    made.save(tmp_path / "kept" / "r.h5")
    again = lc.open(tmp_path / "kept" / "r.h5")
    assert again.dataset.held_pretension.values.tolist() == [45e3, 50e3]
    assert repr(again).endswith("2 runs, 2 ok; lines ['rope'])")
    del made
    assert not first.exists()


def test_arrays_and_numbers_of_any_library_are_values():
    jnp = pytest.importorskip("jax.numpy")
    for values in (np.array([45e3, 50e3]), jnp.array([45e3, 50e3]), [np.array(45e3), 50e3],
                   (jnp.float64(45e3), np.float64(50e3))):  # fmt: skip
        assert api._text(values) == "[45000.0, 50000.0]"
    for value in (np.float64(45e3), jnp.float64(45e3), np.array(45e3), 45e3):
        assert api._text(value) == "45000.0"
    assert api._text({"a": jnp.arange(2), "b": np.bool_(True)}) == "{ a = [0, 1], b = true }"
    assert api._text(np.str_("5 ms")) == "5 ms"


def test_copies_share_a_temporary_folder_and_only_what_is_saved_is_pickled(result, tmp_path):
    folder = tmp_path / "temporary"
    folder.mkdir()
    shutil.copy(result.path, folder / "r.h5")
    made = lc.Result(folder / "r.h5", str(folder))
    copies = [copy.copy(made), copy.deepcopy(made)]
    del made
    with pytest.raises(TypeError, match=r"save\(\) it first"):
        pickle.dumps(copies[0])
    assert copies[1].dataset.held_pretension.values.tolist() == [45e3, 90e3]
    copies[0].save(tmp_path / "kept.h5")
    again = pickle.loads(pickle.dumps(copies[0]))
    assert folder.exists()
    copies.clear()
    assert not folder.exists()
    assert again.dataset.held_pretension.values.tolist() == [45e3, 90e3]


def test_mistakes_are_told_as_on_the_command_line(scene, result, tmp_path):
    with pytest.raises(lc.SceneError, match="pretensoin"):
        lc.run(scene, pretensoin=1)
    with pytest.raises(lc.SceneError, match="expected a non-negative force"):
        lc.run(scene, pretension=-1.0)
    with pytest.raises(lc.ResultError, match="no line 'roep'; nearest: rope"):
        result.line("roep")
    with pytest.raises(lc.ResultError, match=r"there is rope\.end"):
        result.summary("rope.start")
    with pytest.raises(lc.ResultError, match="no such file"):
        lc.open(tmp_path / "none.h5")
    with pytest.raises(lc.ResultError, match="no body 'ship'; there is none"):
        result.body("ship")
    with pytest.raises(lc.ResultError, match="no cable 'rope'; there is none"):
        result.rest("rope")
    with pytest.raises(lc.ResultError, match="asks for no measures"):
        _ = result.measures
    measures = {"top": {"tension": "rope.start"}}
    bare = lc.run(scene, {"measures": measures}, keep="summaries", duration="2 ms")
    with pytest.raises(lc.ResultError, match=r"has no histories of its measures, see output\.keep"):
        _ = bare.measures
    with pytest.raises(lc.ResultError, match=r"has no energies, see output\.quantities"):
        _ = bare.energy
    for run in (2, 0.0, "0"):
        with pytest.raises(lc.ResultError, match=f"expected a run from 0 to 1, found {run!r}"):
            result.view(run)
        with pytest.raises(ValueError, match=f"run: expected one from 0 to 1, found {run!r}"):
            lc.sensitivity(scene, run=run)
    with pytest.raises(lc.OutputError, match=r"x\.h5: No such file or directory$"):
        result.save("/proc/nowhere/x.h5")
    with pytest.raises(TypeError, match="pretension: expected it once"):
        lc.run(scene, {"pretension": 45e3}, pretension=50e3)
    with pytest.raises(TypeError, match="changes: expected values by key, found str"):
        lc.run(scene, "segments=5")
    masked = np.ma.masked_array([45e3, 90e3], [False, True])
    for value, kind in (
        (object(), "object"),
        (b"10 kN", "bytes"),  # a sequence of numbers, but not of those that it shows
        (bytearray(b"45"), "bytearray"),
        (memoryview(b"45"), "memoryview"),
        (np.array([b"10 kN"]), "bytes"),
        (masked, "MaskedArray"),
        ([masked], "MaskedArray"),
        (np.ma.masked, "MaskedConstant"),
    ):
        with pytest.raises(TypeError, match=f"a list or a table, found {kind}$"):
            lc.run(scene, pretension=value)


@pytest.mark.parametrize("title", ["", " ", "12", "a title"])
def test_a_text_may_be_empty(scene, title):
    study = api.changed_study(scene, None, {"title": title})
    assert study.scene.title == title


@pytest.mark.slow
def test_the_types_of_what_users_call_are_complete(tmp_path):
    pyright = shutil.which("pyright")
    if pyright is None:
        pytest.skip("pyright is not installed")
    shutil.copytree(ROOT / "lumpedcable", tmp_path / "on-the-path" / "lumpedcable")
    command = [pyright, "--pythonpath", sys.executable, "--verifytypes", "lumpedcable"]
    ran = subprocess.run(
        [*command, "--ignoreexternal", "--outputjson"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "on-the-path")},
        capture_output=True,
        text=True,
        check=False,
    )
    symbols = json.loads(ran.stdout)["typeCompleteness"]["symbols"]
    rooms = ("api", "results", "scene", "exact", "export", "view", "page", *lc.__all__)
    mine = [s for s in symbols if s["isExported"] and s["name"].split(".")[1] in rooms]
    assert len(mine) > 1500
    assert [s["name"] for s in mine if not s["isTypeKnown"]] == []
