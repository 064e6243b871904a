"""Programs compiled beside each other: those of runs that are still being brought to rest.

What statics finds is but numbers to them. To follow the package's code is Python's work, on one core;
the compiler's goes on beside it, on another.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from threading import Thread
from typing import Any

import jax
import numpy as np
from jax.sharding import SingleDeviceSharding

from lumpedcable.solve.plan import Numbers, Plan
from lumpedcable.study.compiled import ON_CPU, advance_batch, begin_batch
from lumpedcable.study.packed import Packed

__all__ = ["advance_runs", "begin_runs", "foresee"]


class Foreseen:
    """A jitted function that is called once what is done for it ahead is done."""

    def __init__(self, function: Any):
        self.function = function
        self._awaited: list[Future[None]] = []

    def __call__(self, *arguments: Any) -> Any:
        """`function(*arguments)`; other threads may call it too."""
        for done in tuple(self._awaited):
            done.result()
            with suppress(ValueError):  # another thread has seen it
                self._awaited.remove(done)
        return self.function(*arguments)

    def wait_for(self) -> Callable[[], None]:
        """Let calls wait until what comes back is called."""
        done: Future[None] = Future()
        self._awaited.append(done)
        return lambda: None if done.done() else done.set_result(None)


begin_runs, advance_runs = Foreseen(begin_batch), Foreseen(advance_batch)


def foresee(models: Packed, plan: Plan, numbers: Numbers) -> None:
    """Follow `begin_batch` of models to come, and compile `advance_batch`, in a thread of their own.

    Calls of `begin_runs` and `advance_runs` wait for that. Nothing is done where there is one core, or
    several devices. What goes wrong goes wrong once more where it is called, and is told there.

    Args:
        models: as `begin_batch` takes them, with shapes in the place of numbers.
        plan: how they will be stepped.
        numbers: as it takes them; what they are does not matter.
    """
    if not ON_CPU or jax.device_count() > 1 or _cores() == 1:
        return
    followed, compiled = begin_runs.wait_for(), advance_runs.wait_for()

    def work():
        try:
            with suppress(Exception):
                runs, _ = begin_batch.eval_shape(models, plan, numbers)
                followed()
                first = count = np.asarray(0)
                given = models, plan, numbers, _there(runs), first, count, None
                advance_batch.lower(*given).compile()
        finally:
            followed()
            compiled()

    Thread(target=work).start()


def _cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _there(shapes: Any) -> Any:
    """Shapes of arrays that a program has left on the device: to the compiler others than a caller's."""
    place = SingleDeviceSharding(jax.devices()[0])
    return jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=place), shapes)
