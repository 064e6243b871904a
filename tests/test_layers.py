"""The house keeps its shape: imports point one way, and only what computes loads jax."""

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = "lumpedcable"
MODULES = sorted((ROOT / PACKAGE).rglob("*.py"))

# room -> the rooms it may import from; "" is the package's own __init__ (its version)
ALLOWED = {
    "": {"api", "fits", "vibrations"},
    "api": {"export", "page", "results", "scene", "shown", "study", "view"},
    "fits": {"api", "fitting", "results", "scene", "shown", "study", "view"},
    "vibrations": {"api", "results", "scene", "shown", "solve", "study", "view"},
    "shown": {"page"},
    "status": set(),
    "timings": set(),
    "sources": set(),
    "scene": set(),
    "exact": set(),
    "results": set(),
    "physics": set(),
    "model": {"physics", "scene"},
    "solve": {"model", "physics", "scene"},
    "study": {"", "exact", "model", "physics", "results", "scene", "solve"},
    "fitting": {"model", "physics", "results", "scene", "solve", "study"},
    "view": {"results"},
    "export": {"results"},
    "adopt": {"scene"},
    "page": {"exact", "results", "scene", "study"},
    "cli": {"commands", "", "model", "results", "scene", "study", "vibrations"},
    "commands": {"adopt", "export", "fits", "fitting", "page", "results", "scene", "study", "view"},
    "__main__": {"cli"},
}
COMMANDS = {"cli", "commands"}  # import what a command needs when it runs
FREE = {"status", "timings", "sources"}  # words and numbers that any room may use
COMPUTES = {"physics", "model", "solve", "study", "fitting"}
HEAVY = {"jax", "jaxlib", "diffrax", "equinox", "jaxtyping", "lineax", "optimistix"}
# libraries that only some rooms know
OWNERS = dict.fromkeys(HEAVY, COMPUTES) | {
    "h5py": {"export", "results"},
    "matplotlib": {"shown", "view"},
    "pydantic": {"scene", "fitting"},
    "cyclopts": COMMANDS,
    "distributed": {"study"},
    "starlette": {"page"},
    "uvicorn": {"page"},
}


def room_of(module):
    """ "scene" of lumpedcable.scene.units, "" of lumpedcable itself."""
    return [*module.split("."), ""][1]


def name_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@functools.cache  # several tests look at all of them
def imports(source, module, is_package):
    """(module, names, at the top) of every import, wherever it stands, made absolute."""
    return list(_imports(source, module, is_package))


def _imports(source, module, is_package):
    tree = ast.parse(source)
    inside = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        top = id(node) not in inside
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, (), top
        elif isinstance(node, ast.ImportFrom):
            base = module.split(".")
            up = node.level - is_package
            base = base[: len(base) - up] if node.level else []
            target = ".".join([*base, *([node.module] if node.module else [])])
            yield target, tuple(alias.name for alias in node.names), top


def rooms_in(target, names):
    """The rooms that an import from inside the package names."""
    # `from lumpedcable import scene` names a room as well
    if target == PACKAGE:
        return {name if name in ALLOWED else "" for name in names} or {""}
    return {room_of(target)}


def faults(source, module, is_package=False):
    """What is wrong with the imports of one module."""
    room, found = room_of(module), []
    for target, names, top in imports(source, module, is_package):
        outer = target.split(".")[0]
        if outer == PACKAGE:
            found += [
                f"{module} imports {PACKAGE}.{other}".rstrip(".")
                for other in sorted(rooms_in(target, names) - {room} - FREE - ALLOWED[room])
            ]
            found += [f"{module} imports {target}.{n}" for n in names if n.startswith("_")
                      and not n.startswith("__")]  # fmt: skip
            light = {"commands", *FREE}
            if top and room in COMMANDS and target != PACKAGE and room_of(target) not in light:
                found.append(f"{module} imports {target} before a command needs it")
        elif outer in OWNERS and room not in OWNERS[outer]:
            found.append(f"{module} imports {outer}")
    return found


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_point_one_way(path):
    is_package = path.name == "__init__.py"
    assert faults(path.read_text(), name_of(path), is_package) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lumpedcable.exact.waves", "import lumpedcable.model.model"),
        ("lumpedcable.exact.waves", "from lumpedcable import physics"),
        ("lumpedcable.physics.weight", "def f():\n    from lumpedcable.solve.statics import g"),
        ("lumpedcable.physics.tension.table", "from ...model import line"),
        ("lumpedcable.model.line", "from ..solve import bound"),
        ("lumpedcable.solve.bound", "from lumpedcable.results import open_result"),
        ("lumpedcable.scene.load", "import jax.numpy as jnp"),
        ("lumpedcable.view.plot", "import h5py"),
        ("lumpedcable.view.plot", "from lumpedcable import __version__"),
        ("lumpedcable.study.run", "from lumpedcable.scene.load import _read_toml"),
        ("lumpedcable.solve.targets", "from lumpedcable.solve.statics import _rounding"),
        ("lumpedcable.cli", "from lumpedcable.scene import load_study"),
        ("lumpedcable.status", "from lumpedcable.scene import Scene"),
    ],
)
def test_a_wrong_import_is_found(module, source):
    assert len(faults(source, module)) == 1


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lumpedcable.exact.waves", "from .law import Law\nimport numpy"),
        ("lumpedcable.physics.tension.table", "from .base import AbstractTensionLaw"),
        ("lumpedcable.study.run", "from lumpedcable.status import Status\nimport jax"),
        ("lumpedcable.cli", "def run():\n    from lumpedcable.scene import load_study"),
    ],
)
def test_a_right_import_is_let_through(module, source):
    assert faults(source, module) == []


def arrows(modules):
    """By module those that it imports; `modules` are (source, module, is a package).

    The package's own names are imported when they are first asked for, so that it points nowhere.
    """
    known = {module for _, module, _ in modules} - {PACKAGE}
    return {
        module: {
            inner if (inner := f"{target}.{name}") in known else target
            for target, names, _ in imports(source, module, is_package)
            for name in names or ("",)
        }
        & known
        for source, module, is_package in modules
    }


def circles(arrows):
    """The modules that lead back to themselves."""

    def beyond(module):
        found, left = set(), [module]
        while left:
            new = arrows.get(left.pop(), set()) - found
            found |= new
            left += new
        return found

    return {module for module in arrows if module in beyond(module)}


def test_no_import_leads_back():
    # those for types as well: a reader goes by them
    modules = [(path.read_text(), name_of(path), path.name == "__init__.py") for path in MODULES]
    assert circles(arrows(modules)) == set()


def test_a_circle_is_found():
    there = "from lumpedcable.model import line"
    back = "if TYPE_CHECKING:\n    from lumpedcable.model.net import Net"
    rest = ("from lumpedcable.model.net import Net", "lumpedcable.model.cuts", False)
    net, line = (there, "lumpedcable.model.net", False), (back, "lumpedcable.model.line", False)
    assert circles(arrows([net, line, rest])) == {"lumpedcable.model.net", "lumpedcable.model.line"}
    assert circles(arrows([net, ("", "lumpedcable.model.line", False), rest])) == set()


def unused(allowed, modules):
    """Ways that are allowed and that nobody goes; `modules` are (source, module, is a package)."""
    gone = {
        (room_of(module), other)
        for source, module, is_package in modules
        for target, names, _ in imports(source, module, is_package)
        if target.split(".")[0] == PACKAGE
        for other in rooms_in(target, names)
    }
    return {(room, other) for room, others in allowed.items() for other in others} - gone


def test_every_way_that_is_allowed_is_gone():
    modules = [(path.read_text(), name_of(path), path.name == "__init__.py") for path in MODULES]
    assert unused(ALLOWED, modules) == set()


def test_a_way_that_nobody_goes_is_found():
    module = ("from lumpedcable import exact", "lumpedcable.page.live", False)
    assert unused({"page": {"exact", "scene"}}, [module]) == {("page", "scene")}


def test_every_room_is_on_the_plan():
    assert {room_of(name_of(path)) for path in MODULES} == set(ALLOWED)


def test_every_room_is_in_the_words_of_the_plan():
    plan = (ROOT / "docs" / "architecture.md").read_text().split("```")[1]
    told = {line.split()[0] for line in plan.splitlines() if re.match(r" [a-z]", line)}
    assert told == set(ALLOWED) - {"", "__main__"}


@pytest.mark.parametrize(
    "module",
    ["lumpedcable", "lumpedcable.scene", "lumpedcable.results", "lumpedcable.view",
     "lumpedcable.page.open", "lumpedcable.exact", "lumpedcable.cli"],
)  # fmt: skip
def test_what_does_not_compute_does_not_load_jax(module):
    code = (
        f"import sys, {module}; "
        f"print(sorted({HEAVY!r} & {{name.partition('.')[0] for name in sys.modules}}))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert ran.stdout.strip() == "[]"


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_every_module_says_what_it_is_for(path):
    assert ast.get_docstring(ast.parse(path.read_text()))


def test_files_stay_readable():
    folders = [ROOT / PACKAGE, ROOT / "tests", ROOT / "benchmarks"]
    sizes = {
        str(path.relative_to(ROOT)): path.read_text().count("\n")
        for folder in folders
        for path in folder.rglob("*.py")
    }
    assert {name: lines for name, lines in sizes.items() if lines > 400} == {}
