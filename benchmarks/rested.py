"""Parted lines of many pretensions at rest, ready to go through time in batches."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from benchmarks.engine import SCENE
from benchmarks.studies import SWEEP
from lumpedcable.model.numbers import number
from lumpedcable.scene import load_study
from lumpedcable.solve.plan import Numbers
from lumpedcable.study.compiled import Ready
from lumpedcable.study.laying import Laid, lay_out
from lumpedcable.study.plan import rounded_steps
from lumpedcable.study.starts import starts


class Rested(NamedTuple):
    """Runs at rest: their study, their models, steps in an output interval, the plan's numbers."""

    laid: Laid
    ready: Ready
    steps: int
    numbers: Numbers


def rested(runs: int, segments: int, every: float, dtype: str) -> Rested:
    """So many runs, with samples each `every` (s) and the steps of the one that needs the most."""
    changes = (SWEEP.format(runs), f"segments={segments}", f"every={every} s")
    laid = lay_out(
        load_study(SCENE, (*changes, 'output.keep="summaries"', f'solver.dtype="{dtype}"'))
    )
    ready = starts(laid, laid.structures[0], np.arange(runs))
    steps = int(rounded_steps(laid.scene, np.asarray(ready.bound)).max())
    numbers = Numbers(number(every), jnp.asarray(steps), number(1.0), number(1.0))
    return Rested(laid, ready, steps, numbers)
