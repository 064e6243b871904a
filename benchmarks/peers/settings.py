"""What a peer hands back for one run at one of its settings."""

from __future__ import annotations

from typing import NamedTuple

from benchmarks.measures import Histories


class Outcome(NamedTuple):
    """Histories at 1 ms and finer, seconds of a warm run and of compiling, work done and its unit."""

    histories: Histories
    fine: Histories
    warm: float
    compile: float
    steps: int
    unit: str
    status: str
