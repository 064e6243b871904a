"""Many ropes at once: each as if it were alone."""

import csv
import json

import numpy as np
import pytest
from command_line import refused, say
from fit_files import BENCH, NAMES, SCENE, TRUTH, fit_of, free, write_bench
from nylon_line import P5, tension

from lumpedcable.fitting.ropes import fit_ropes
from lumpedcable.fitting.run import fit_problem

ROPES = {"a1": (1.0, 40), "b.2": (1.15, 64), "07": (0.9, 51)}
"""Their p1 to p4 over the nylon rope's, and how many points were measured."""
STRAIN = np.linspace(0.005, 0.32, 40)
TEXT = 'scene = "scene.toml"\nropes = "*"\n' + free(TRUTH[:4], NAMES[:4])
TEXT += BENCH.replace("bench.csv", "coil-{rope}.csv")


def written(folder, text=TEXT, noise=0.0):
    random = np.random.default_rng(2)
    for name, (factor, points) in ROPES.items():
        p1, p2, p3, p4 = factor * TRUTH[:4]
        e = np.linspace(0.005, 0.32, points)
        load = p1 * np.tanh(p2 * e + p3) + p4 + P5 * e
        load = load + noise * 4e5 * random.standard_normal(points)
        write_bench(folder, e, load, f"coil-{name}.csv")
    return fit_of(folder, text)


def test_every_rope_comes_back_as_it_is(tmp_path):
    study = written(tmp_path)
    assert list(study.ropes) == sorted(ROPES)
    for name, fitted in fit_ropes(study.ropes).items():
        assert fitted.converged
        assert fitted.values == pytest.approx(ROPES[name][0] * TRUTH[:4], rel=1e-6)


def test_signs_of_patterns_in_the_name_of_a_folder_are_letters(tmp_path):
    (tmp_path / "coils [x]").mkdir()
    text = TEXT.replace("coil-{rope}", "coils [x]/{rope}")
    for name in ROPES:
        write_bench(tmp_path, STRAIN, tension(STRAIN), f"coils [x]/{name}.csv")
    assert list(fit_of(tmp_path, text).ropes) == sorted(ROPES)


def test_a_rope_among_others_is_what_it_is_alone(tmp_path):
    study = written(tmp_path, noise=0.01)
    together = fit_ropes(study.ropes)
    for name, problem in study.ropes.items():
        alone = fit_problem(problem)
        assert together[name].values == pytest.approx(alone.values, rel=1e-6)
        assert together[name].certainty.std == pytest.approx(alone.certainty.std, rel=1e-4)
        assert together[name].criteria == pytest.approx(alone.criteria, rel=1e-6)
        assert [p.size for p in together[name].predicted] == [ROPES[name][1]]


def test_the_command_writes_all_ropes(tmp_path):
    written(tmp_path, noise=0.01)
    said = say(tmp_path, "fit", "fit.toml", "-o", "out")
    assert said.code == 0, said.err
    with (tmp_path / "out" / "ropes.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["rope"] for row in rows] == sorted(ROPES)
    told = json.loads((tmp_path / "out" / "fit.json").read_text())["ropes"]
    for row in rows:
        first = told[row["rope"]]["parameters"][0]
        assert float(row["materials.nylon.p1 (N)"]) == pytest.approx(first["value"], rel=1e-9)
        scene = tmp_path / "out" / row["rope"] / "scene-fitted.toml"
        assert say(tmp_path, "check", scene).code == 0
    assert (tmp_path / "out" / "ropes.png").exists()


def test_one_rope_has_all_its_pictures_and_a_name_may_hold_a_comma(tmp_path):
    written(tmp_path, noise=0.01)
    (tmp_path / "coil-b.2.csv").rename(tmp_path / "coil-B,2.csv")
    for other in ("a1", "07"):
        (tmp_path / f"coil-{other}.csv").unlink()
    said = say(tmp_path, "fit", "fit.toml", "-o", "out")
    assert said.code == 0, said.err
    with (tmp_path / "out" / "ropes.csv").open(newline="") as file:
        head, row = csv.reader(file)
    assert len(head) == len(row)
    assert row[0] == "B,2"
    named = (tmp_path / "fit.toml").read_text().replace('ropes = "*"', 'ropes = ["B,2"]')
    (tmp_path / "named.toml").write_text(named)
    assert say(tmp_path, "fit", "named.toml", "-o", "named").code == 0
    # as of a file that names no ropes
    assert {"data.png", "laws.png"} < {p.name for p in (tmp_path / "out" / "B,2").iterdir()}


@pytest.mark.parametrize(
    ("text", "said"),
    [(TEXT.replace('ropes = "*"\n', ""), 'expected ropes = ["NAME", ...] for the "{rope}"'),
     (TEXT.replace('"*"', '["a1", "a1"]'), 'expected each rope once, found "a1"'),
     (TEXT.replace('"*"', '["../a1"]'), 'names that files can have, without / and \\, found "../a1"'),
     (TEXT.replace('"*"', '"a1"'), 'ropes: expected a list of names of ropes, or "*" for all'),
     (TEXT.replace('"*"', '[]'), 'ropes: expected a list of names of ropes, or "*" for all'),
     (TEXT.replace('"*"', '["a1", 5]'), 'ropes: expected a list of names of ropes, or "*"'),
     (TEXT.replace('"*"', '["a9"]'), "coil-a9.csv"),
     (TEXT.replace("coil-{rope}", "coil-a1"), 'expected "{rope}" in the file of an experiment'),
     (TEXT.replace("coil-{rope}", "spool-{rope}"), "expected files like spool-{rope}.csv"),
     (TEXT + "[sample]\n", "expected no sample where there are ropes")],
)  # fmt: skip
def test_a_mistake_is_told(tmp_path, text, said):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "coil-a1.csv").write_text("strain (%),load\n1,2\n2,3.5\n3,5\n4,5\n5,6\n")
    (tmp_path / "fit.toml").write_text(text)
    told = refused(tmp_path, "fit", "fit.toml")
    assert said in told
    assert all(line.startswith("fit.toml:") for line in told.splitlines())
