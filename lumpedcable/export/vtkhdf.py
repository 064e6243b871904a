"""VTKHDF for ParaView: an unstructured grid of line cells with its time steps.

Source: VTK file formats, "VTKHDF file format", version 2.1 for `Steps` of unstructured grids
(docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format).
"""

from __future__ import annotations

import io
import shutil
from pathlib import Path

import h5py
import numpy as np

from lumpedcable.export.parts import lines_of, replacing
from lumpedcable.results import ResultFile

__all__ = ["write_vtkhdf"]

_VERSION = (2, 1)
_LINE = 3  # VTK_LINE


def write_vtkhdf(result: ResultFile, target: Path, run: int | None) -> list[Path]:
    """Write all lines of one run, every time with fields a step.

    Points are the nodes (m); cells the segments. Point data: velocity (m/s), and where a line bends
    the bending moment (N m), NaN along the others; cell data: tension (N),
    strain (-), and line, the number of the line in the file. The mesh is written once; points and
    data follow step by step.
    """
    lines = lines_of(result, run or 0)
    time = result.field_time
    steps = len(time)
    points = np.concatenate([line.position for line in lines], axis=1)
    nodes = points.shape[1]
    pairs, owners, first = [], [], 0
    for number, line in enumerate(lines):
        count = line.position.shape[1]
        at = first + np.arange(count - 1)
        pairs.append(np.column_stack([at, at + 1]))
        owners.append(np.full(count - 1, number))
        first += count
    connectivity = np.concatenate(pairs).ravel()
    cells = connectivity.size // 2
    made = io.BytesIO()  # HDF5 itself says little of a full disk, and only when it closes the file
    with h5py.File(made, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = np.array(_VERSION, "i8")
        root.attrs.create("Type", np.bytes_(b"UnstructuredGrid"))
        for name, value in (
            ("NumberOfPoints", np.full(steps, nodes)),
            ("NumberOfCells", np.full(steps, cells)),
            ("NumberOfConnectivityIds", np.full(steps, connectivity.size)),
            ("Connectivity", connectivity),
            ("Offsets", 2 * np.arange(cells + 1)),
        ):
            root.create_dataset(name, data=np.asarray(value, "i8"))
        root.create_dataset("Types", data=np.full(cells, _LINE, "u1"))
        root.create_dataset("Points", data=points.reshape(-1, 3).astype("f8"))
        own = {"PointData": {}, "CellData": {}}
        for field in dict.fromkeys(field for li in lines for field in li.nodes):
            own["PointData"][field] = np.concatenate(
                [li.nodes.get(field, np.full(li.position.shape[:2], np.nan)) for li in lines],
                axis=1,
            )
        for field in lines[0].segments:
            own["CellData"][field] = np.concatenate([li.segments[field] for li in lines], axis=1)
        for group, fields in own.items():
            for name, table in fields.items():
                flat = table.reshape(steps * table.shape[1], *table.shape[2:])
                root.create_dataset(f"{group}/{name}", data=flat.astype("f4"))
        root.create_dataset("CellData/line", data=np.concatenate(owners).astype("i4"))
        _steps(root, time, nodes, cells, own)
    made.seek(0)
    with replacing(target, "VTKHDF") as partial, partial.open("wb") as out:
        shutil.copyfileobj(made, out)
    return [target]


def _steps(root: h5py.Group, time, nodes: int, cells: int, own) -> None:
    """Where each step's points and data begin; the cells are those of the first."""
    count = len(time)
    group = root.create_group("Steps")
    group.attrs["NSteps"] = np.int64(count)
    group.create_dataset("Values", data=np.asarray(time, "f8"))
    still, each = np.zeros(count, "i8"), np.arange(count, dtype="i8")
    for name, value in (
        ("PartOffsets", still),
        ("NumberOfParts", still + 1),
        ("PointOffsets", each * nodes),
        ("CellOffsets", still[:, None]),
        ("ConnectivityIdOffsets", still[:, None]),
    ):
        group.create_dataset(name, data=value)
    for kind, size in (("PointData", nodes), ("CellData", cells)):
        for name in own[kind]:
            group.create_dataset(f"{kind}Offsets/{name}", data=each * size)
    group.create_dataset("CellDataOffsets/line", data=still)
