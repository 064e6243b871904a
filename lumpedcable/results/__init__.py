"""Results in HDF5: written piece by piece while a study runs, read lazily afterwards.

Knows nothing of the engine: variables come in by name, dimension and unit, and go out the same way.
"""

from lumpedcable.results.describe import describe
from lumpedcable.results.errors import OutputError, ResultError
from lumpedcable.results.folder import Manifest, StudyFolder, is_study_folder
from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import Axis, ResultFile, open_result
from lumpedcable.results.schema import (
    FIELD_TIME,
    SCHEMA_VERSION,
    Coordinate,
    Variable,
    axis_names,
    exact_name,
    sweep_coordinates,
)
from lumpedcable.results.writer import ResultWriter

__all__ = [
    "FIELD_TIME",
    "SCHEMA_VERSION",
    "Axis",
    "Coordinate",
    "LineData",
    "Manifest",
    "OutputError",
    "ResultError",
    "ResultFile",
    "ResultWriter",
    "StudyFolder",
    "Variable",
    "axis_names",
    "describe",
    "exact_name",
    "is_study_folder",
    "open_result",
    "sweep_coordinates",
]
