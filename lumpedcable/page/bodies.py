"""Bodies that the results file follows, as plain solids of the right size and attitude."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.page.pack import Pack
from lumpedcable.results.reader import ResultFile

__all__ = ["moved_bodies"]


def moved_bodies(
    result: ResultFile, runs: NDArray[Any], times: NDArray[Any], pack: Pack
) -> list[dict[str, Any]]:
    """Every body with a stored place: a box where its size is known, a ball where it is not.

    Args:
        result: the open file.
        runs: the runs shown.
        times: indices of the saved times shown.
        pack: takes the arrays, x, y, z of (run, frame) in m, and w, x, y, z of the
            attitude, a unit quaternion from the body's axes to the scene's.

    Returns:
        One table per body: name, size (length, breadth, height in m) or None, and its arrays.
    """
    found = []
    for name in result.series.bodies:
        size = result.group_attributes(f"bodies/{name}").get("size")
        body: dict[str, Any] = {
            "name": name,
            "size": None if size is None else [float(v) for v in np.atleast_1d(size)],
        }
        for field in ("position", "attitude"):
            path = f"bodies/{name}/{field}"
            if result.series.has(path):
                values = [result.series.read(path, int(run))[times] for run in runs]
                body[field] = [pack.field(part) for part in np.moveaxis(np.array(values), -1, 0)]
        found.append(body)
    return found
