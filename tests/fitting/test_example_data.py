"""The measurements beside the example fits are those that this engine makes of the known numbers."""

import importlib.util
import shutil

import numpy as np
from command_line import ROOT

FIT = ROOT / "configs" / "fit"


def test_they_are_what_their_program_makes_of_them(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("make_data", FIT / "make_data.py")
    assert spec is not None
    assert spec.loader is not None
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    shutil.copy(ROOT / "configs" / "snapback.toml", tmp_path)
    (tmp_path / "fit").mkdir()
    monkeypatch.setattr(program, "HERE", tmp_path / "fit")
    program.main()
    made = sorted(path.name for path in (tmp_path / "fit").iterdir())
    assert made == sorted(path.name for path in FIT.glob("*.csv"))
    for name in made:
        here, there = (
            np.loadtxt(folder / name, delimiter=",", skiprows=2, ndmin=2)
            for folder in (FIT, tmp_path / "fit")
        )
        # a tenth of the noise: what another machine rounds grows where a line crumples
        far = np.abs(here - there).max(axis=0) / np.abs(here).max(axis=0)
        assert far.max() < 1e-3, name
