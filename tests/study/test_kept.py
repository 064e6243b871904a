"""What programs do is followed once: the next process reads it, and does the same."""

import os
import pickle
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import h5py
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tiny_scene import TINY

from lumpedcable.study import kept as module
from lumpedcable.study.kept import kept, program
from lumpedcable.study.packed import Packed, pack

ROOT = Path(__file__).parents[2]


class Counted:
    """A function that counts how often it is followed."""

    def __init__(self, function):
        self.function, self.calls = function, 0

    def __call__(self, *arguments):
        self.calls += 1
        return self.function(*arguments)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Programs are kept in a folder of this test's alone."""
    monkeypatch.setattr(module, "KEEPS", True)
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path
    jax.config.update("jax_compilation_cache_dir", before)


def files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.followed"))


def called(function, told, *arguments):
    """The result as of a new process: of a function that jax does not know yet."""
    return jax.jit(lambda *given: kept(function, told, *given))(*arguments)


def squares(tree):
    return {"sum": jnp.sum(tree["x"] ** 2), "packed": pack((tree["x"] + tree["y"], tree["y"]))}


TREE = {"x": np.linspace(0.0, 1.0, 5), "y": np.float64(2.0)}


def test_a_function_is_followed_once_and_does_the_same(folder):
    function = Counted(squares)
    first = called(function, "squares", TREE)
    assert function.calls == 1
    assert len(files(folder)) == 1
    again = called(function, "squares", {"x": TREE["x"] + 1.0, "y": TREE["y"]})
    assert function.calls == 1
    assert isinstance(again["packed"], Packed)
    assert jax.tree.structure(again) == jax.tree.structure(first)
    plain = squares({"x": TREE["x"] + 1.0, "y": TREE["y"]})
    assert jax.tree.structure(plain) == jax.tree.structure(again)
    for mine, other in zip(jax.tree.leaves(again), jax.tree.leaves(plain), strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-15)


@pytest.mark.parametrize(
    ("told", "tree"),
    [
        ("others", TREE),
        (("squares", 1), TREE),
        ("squares", TREE | {"x": np.ones(6)}),
        ("squares", TREE | {"x": np.ones(5, np.float32)}),
        ("squares", TREE | {"y": 2.0}),  # a plain number takes the type of what it meets
        ("squares", TREE | {"z": np.float64(1.0)}),
    ],
)
def test_what_is_told_or_given_otherwise_is_followed_anew(folder, told, tree):
    function = Counted(squares)
    called(function, "squares", TREE)
    mine = called(function, told, tree)
    assert function.calls == len(files(folder)) == 2
    np.testing.assert_allclose(mine["sum"], np.sum(np.asarray(tree["x"]) ** 2), rtol=1e-6)


OTHERS = zlib.compress(pickle.dumps((1, 2)))


@pytest.mark.parametrize("left", [b"", b"nonsense", OTHERS, None])
def test_a_file_that_is_not_understood_is_made_anew(folder, left):
    function = Counted(squares)
    called(function, "squares", TREE)
    (file,) = files(folder)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if left is None else left)
    called(function, "squares", TREE)
    assert function.calls == 2
    called(function, "squares", TREE)
    assert function.calls == 2
    assert files(folder) == [file]


def test_other_sources_are_another_program(folder, monkeypatch):
    function = Counted(squares)
    called(function, "squares", TREE)
    monkeypatch.setattr(module, "SOURCES", "0" * 32)
    called(function, "squares", TREE)
    assert function.calls == 2
    # what is imported is not what lies there now: nobody could say of which sources it is
    assert len(files(folder)) == 1


def test_without_a_cache_a_function_is_followed_as_ever(folder, monkeypatch):
    function = Counted(squares)
    jax.config.update("jax_compilation_cache_dir", None)
    called(function, "squares", TREE)
    jax.config.update("jax_compilation_cache_dir", str(folder))
    called(function, lambda: "squares", TREE)  # could be any
    monkeypatch.setattr(module, "SOURCES", None)
    called(function, "squares", TREE)
    monkeypatch.undo()
    monkeypatch.setattr(module, "KEEPS", True)
    monkeypatch.setattr(module, "write_whole", lambda *_: (_ for _ in ()).throw(OSError("full")))
    called(function, "squares", TREE)
    assert function.calls == 4
    with jax.disable_jit():
        kept(squares, "squares", TREE)
    assert files(folder) == []


def test_what_is_wrong_with_a_function_is_told_as_ever(folder):
    def wrong(tree):
        raise ArithmeticError("no equilibrium")

    with pytest.raises(ArithmeticError, match="no equilibrium"):
        called(wrong, "wrong", TREE)
    assert files(folder) == []


def test_operations_that_cannot_be_kept_are_done_and_not_tried_again(folder):
    seen = []

    def talking(tree):
        jax.debug.callback(seen.append, tree["y"])
        return tree["y"] + 1.0

    function = Counted(talking)
    for calls in (2, 3):  # once in vain, for good
        assert called(function, "talking", TREE) == 3.0
        jax.effects_barrier()
        assert function.calls == calls
    assert seen == [2.0, 2.0]


def test_arguments_that_are_structure_are_told_by_their_values(folder):
    def power(x, exponent, offset=0.0):
        return x**exponent + offset

    power.__qualname__ = "power"
    for count, exponent in ((1, 2), (2, 3), (2, 2)):
        raised = program(power, ("exponent",))  # as in a new process
        assert raised(3.0, exponent=exponent) == 3.0**exponent
        assert raised(2.0, exponent) == 2.0**exponent
        assert len(files(folder)) == count
    assert program(power, ("exponent",))(3.0, 2, offset=1.0) == 10.0
    assert len(files(folder)) == 3


def ran(folder: Path, code: str, *overrides: str) -> Path:
    """The results of a scene, in a process of its own."""
    out = folder / "out.h5"
    script = f"{code}\nimport sys\nfrom lumpedcable.cli import main\nmain()"
    sets = [word for one in overrides for word in ("--set", one)]
    done = subprocess.run(
        [sys.executable, "-c", script, "run", "scene.toml", "-o", str(out), *sets],
        cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "LUMPEDCABLE_CACHE": str(folder / "cache")},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def bits(file: Path) -> dict[str, np.ndarray]:
    """All numbers of a result file."""
    found = {}
    with h5py.File(file) as results:
        results.visititems(
            lambda name, x: found.update({name: x[()]}) if isinstance(x, h5py.Dataset) else None
        )
    return {k: v for k, v in found.items() if v.dtype.kind == "f"}


@pytest.mark.slow
def test_sources_that_change_under_a_process_are_not_its_own(tmp_path):
    """What a notebook has imported stays what it is, whatever is installed meanwhile."""
    package = tmp_path / "copy"
    shutil.copytree(ROOT / "lumpedcable", package / "lumpedcable")
    law = package / "lumpedcable/physics/tension/linear.py"
    changed = law.read_text().replace("self.EA * strain", "2.0 * self.EA * strain")
    assert changed != law.read_text()
    (tmp_path / "scene.toml").write_text(TINY)
    (tmp_path / "changed.py").write_text(changed)
    code = f"""
import sys
sys.path.insert(0, {str(package)!r})
import lumpedcable.physics.tension.linear
from pathlib import Path
Path({str(law)!r}).write_text(Path("changed.py").read_text())
"""
    before = bits(ran(tmp_path, code))["lines/rope/position"]
    assert files(tmp_path / "cache") == []
    after = bits(ran(tmp_path, code))["lines/rope/position"]
    # 50 kN stretch 10 m of 1 MN by 0.5 m, of 2 MN by 0.25 m
    assert before[0, 0, -1, 0] == pytest.approx(10.5, abs=1e-6)
    assert after[0, 0, -1, 0] == pytest.approx(10.25, abs=1e-6)


FORBIDDEN = """
from lumpedcable.study import compiled
def followed(*_): raise AssertionError("followed again")
compiled.rest_of = compiled.begin = compiled.advance = followed
"""


@pytest.mark.parametrize(
    "overrides",
    [pytest.param((), marks=pytest.mark.slow), ("pretension=[30 kN, 40 kN, 50 kN, 60 kN]",)],
)
@pytest.mark.slow
def test_a_second_process_follows_nothing_and_finds_the_same(tmp_path, overrides):
    """One run, and four that are shared out to the cores."""
    (tmp_path / "scene.toml").write_text(TINY)
    first = bits(ran(tmp_path, "", *overrides))
    assert len(files(tmp_path / "cache")) == 3
    again = bits(ran(tmp_path, FORBIDDEN, *overrides))
    assert first.keys() == again.keys()
    assert any(np.any(v != 0.0) for v in first.values())
    for name, values in first.items():
        np.testing.assert_array_equal(values, again[name], err_msg=name)


@pytest.mark.slow
def test_another_number_is_the_same_program(tmp_path):
    (tmp_path / "scene.toml").write_text(TINY)
    ran(tmp_path, "", "break.time=20 ms")
    ran(tmp_path, FORBIDDEN, "break.time=40 ms", "mass=2 kg/m")


TABLED = TINY.replace('law = "linear"\nEA = "1 MN"', 'law = "table"\nfile = "rope.csv"')


@pytest.mark.slow
def test_a_table_that_was_changed_is_another_program(tmp_path):
    """Data that are read from a file are in the program, not among its numbers."""
    (tmp_path / "scene.toml").write_text(TABLED)
    strain = np.linspace(0.0, 0.2, 9)
    tensions = []
    for stiffness in (1e6, 2e6):
        rows = [f"{e},{stiffness * e}" for e in strain]
        (tmp_path / "rope.csv").write_text("\n".join(["strain,tension (N)", *rows]) + "\n")
        found = bits(ran(tmp_path, ""))
        position = found["lines/rope/position"]
        tensions.append(np.max(position[..., 0]) / 10.0 - 1.0)
    # 50 kN stretch the rope half as far
    np.testing.assert_allclose(tensions, [0.05, 0.025], rtol=1e-3)
    # once at rest its values are among the numbers of a model
    assert len(files(tmp_path / "cache")) == 4
