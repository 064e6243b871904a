"""Runs that go through time together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumpedcable.solve.plan import Numbers, Plan
from lumpedcable.study.compiled import Structure

__all__ = ["Part"]


@dataclass(frozen=True)
class Part:
    """Runs of one structure that go through time together, stepped alike.

    Attributes:
        structure: what they share.
        runs: their numbers in the study, shape (runs,).
        rows: their rows in the block, shape (runs,).
        size: lanes of the batch; those beyond the runs repeat the last one.
        plan: how they are stepped.
        numbers: steps in each output interval, and what else steps are taken with.
    """

    structure: Structure
    runs: NDArray[np.int64]
    rows: NDArray[np.int64]
    size: int
    plan: Plan
    numbers: Numbers

    @property
    def steps(self) -> int:
        """Steps in each output interval."""
        return int(self.numbers.steps)
