"""What there is: the scene language, read from TOML into frozen models in SI units.

:func:`load_study` reads a file; :func:`read_scene` reads tables that are there already;
:class:`Scene` is one run; :func:`json_schema` describes the file.
Nothing here imports jax.
"""

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import (
    FixedEnd,
    HarmonicMotion,
    HeldEnd,
    HeldForce,
    HeldPosition,
    MovingEnd,
    RecordedMotion,
)
from lumpedcable.scene.environment import (
    Fluid,
    PowerCurrent,
    Seabed,
    TableCurrent,
    UniformCurrent,
)
from lumpedcable.scene.errors import Fault, SceneError
from lumpedcable.scene.events import Event
from lumpedcable.scene.lines import (
    AddedMass,
    Bending,
    Drag,
    Line,
)
from lumpedcable.scene.load import Study, load_study
from lumpedcable.scene.materials import (
    LinearMaterial,
    PolynomialMaterial,
    TableMaterial,
    TanhMaterial,
)
from lumpedcable.scene.run import Output, Reference, Solver, Statics
from lumpedcable.scene.run_checks import CHECKED
from lumpedcable.scene.runs import Axis, Factor, Runs
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.schema import json_schema
from lumpedcable.scene.targets import Target
from lumpedcable.scene.units import UnitError, format_quantity, parse_quantity
from lumpedcable.scene.validate import read_scene

__all__ = [
    "CHECKED",
    "AddedMass",
    "Axis",
    "Bending",
    "Body",
    "Drag",
    "Event",
    "Factor",
    "Fault",
    "FixedEnd",
    "Fluid",
    "HarmonicMotion",
    "HeldEnd",
    "HeldForce",
    "HeldPosition",
    "Line",
    "LinearMaterial",
    "MovingEnd",
    "Output",
    "PolynomialMaterial",
    "PowerCurrent",
    "RecordedMotion",
    "Reference",
    "Runs",
    "Scene",
    "SceneError",
    "Seabed",
    "Solver",
    "Statics",
    "Study",
    "TableCurrent",
    "TableMaterial",
    "TanhMaterial",
    "Target",
    "UniformCurrent",
    "UnitError",
    "format_quantity",
    "json_schema",
    "load_study",
    "parse_quantity",
    "read_scene",
]
