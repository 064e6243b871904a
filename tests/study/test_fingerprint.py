"""Structure is told by the same words in every process, and by others where it is another."""

import enum
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import jax
import numpy as np
import pytest

from lumpedcable.scene import load_study
from lumpedcable.solve.plan import Plan
from lumpedcable.sources import PACKAGE, code_of
from lumpedcable.study.compiled import Structure
from lumpedcable.study.fingerprint import UntoldError, fingerprint
from lumpedcable.study.packed import Form
from lumpedcable.study.plan import plan_of, structure_of

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "configs/highline/transfer.toml"
ASKED = f"""
import sys
from lumpedcable.scene import load_study
from lumpedcable.study.fingerprint import fingerprint
from lumpedcable.study.plan import plan_of, structure_of
scene = load_study({str(SCENE)!r}).runs[0]
structure = structure_of(scene)
print(fingerprint(structure, plan_of(scene, structure.layout), frozenset(sys.argv[1:])))
"""


def structures() -> tuple[Structure, Plan]:
    scene = load_study(SCENE).runs[0]
    structure = structure_of(scene)
    return structure, plan_of(scene, structure.layout)


@pytest.mark.slow
def test_another_process_tells_the_same():
    """Texts are hashed otherwise in each process, so that sets have another order."""
    words = ("heave", "surge", "sway", "roll", "pitch", "yaw")
    told = {
        subprocess.run(
            [sys.executable, "-c", ASKED, *words],
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": seed},
            capture_output=True, text=True, check=True,
        ).stdout.strip()
        for seed in ("1", "77")
    }  # fmt: skip
    assert told == {fingerprint(*structures(), frozenset(words))}


def test_what_differs_is_told_apart():
    structure, plan = structures()
    tree = jax.tree.structure
    things = [
        structure, replace(structure, skeleton=structure.skeleton + " "), plan,
        replace(plan, outputs=plan.outputs + 1), replace(plan, method="heun"), None, 0, 0.0, -0.0, False,
        "", "0", b"0", (), [], {}, set(), (0,), [0], (0, 0), (0, (0,)), ((0,), 0), {"a": 0}, {"b": 0},
        {"a": 0, "b": 1}, {"b": 1, "a": 0}, {0}, np.float64(0.0), np.dtype("f4"), np.dtype("f8"),
        tree(0), tree((0,)), tree([0]), tree({"a": 0}), tree({"b": 0}), tree(None),
        Form(tree(0), ((),), ("float64",)), Form(tree((0,)), ((),), ("float64",)),
        ("tree", 0), Plan, Structure, structure_of, plan_of,
    ]  # fmt: skip
    told = [fingerprint(thing) for thing in things]
    assert len(set(told)) == len(things)


def test_what_does_not_count_when_two_are_compared_does_not_count_here():
    """The scene of a structure is any that has it."""
    structure, _ = structures()
    other = load_study(SCENE, ["gravity=9.7 m/s2"]).runs[0]
    assert structure == replace(structure, scene=other)
    assert fingerprint(structure) == fingerprint(replace(structure, scene=other))


@dataclass(frozen=True)
class Foreign:
    """Of a module that can change while the package does not."""

    number: int = 1


class Kind(enum.Enum):
    ONE = 1


def enclosing(number: int):
    def inner():
        return number

    return inner


@pytest.mark.parametrize(
    "thing",
    [
        np.zeros(3), jax.numpy.zeros(3), lambda: 0, enclosing(1), partial(abs, 1), Foreign(), Foreign,
        Kind.ONE, enclosing, object(), iter(()), (1, [lambda: 0]), {"a": {"b": Foreign()}},
    ],
)  # fmt: skip
def test_what_could_be_mistaken_is_not_told(thing):
    with pytest.raises(UntoldError):
        fingerprint(thing)


def test_each_byte_and_name_of_the_sources_counts(tmp_path):
    shutil.copytree(
        PACKAGE / "physics", tmp_path / "a", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    told = code_of(tmp_path / "a")
    assert told == code_of(tmp_path / "b") != code_of()
    file = tmp_path / "b" / "ramp.py"
    source = file.read_bytes()
    file.write_bytes(source.replace(b"0.5", b"0.6", 1))
    changed = code_of(tmp_path / "b")
    file.write_bytes(source)
    assert code_of(tmp_path / "b") == told != changed
    file.rename(tmp_path / "b" / "slope.py")
    assert code_of(tmp_path / "b") not in (told, changed)


def test_a_package_without_sources_has_no_digest(tmp_path):
    """Of compiled files alone nobody knows which code they are."""
    (tmp_path / "engine.pyc").write_bytes(b"engine")
    assert code_of(tmp_path) is code_of(tmp_path / "engine.pyc") is None
