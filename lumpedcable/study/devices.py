"""A batch shared out over all devices: cores of this machine, or several GPUs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.extend.backend
import numpy as np
from jax.sharding import Mesh, PartitionSpec

from lumpedcable.status import PlatformError

__all__ = ["at_hand", "platform", "shared_out"]


def platform() -> str:
    """What jax computes on: "cpu", "gpu" or "tpu".

    Raises:
        PlatformError: JAX_PLATFORMS asks for what is not there.
    """
    try:
        return jax.default_backend()
    except (RuntimeError, AssertionError) as error:  # the second where jax has no words for it
        config: Any = jax.config
        asked = config.jax_platforms
        jax.config.update("jax_platforms", None)
        there = sorted({"cpu", jax.default_backend()})
        # whoever tries again is told again
        jax.config.update("jax_platforms", asked)
        jax.extend.backend.clear_backends()
        raise PlatformError(
            f"JAX_PLATFORMS: expected {' or '.join(there)}, which jax finds here, found {asked!r}"
        ) from error


def at_hand(tree: Any) -> Any:
    """Arrays that several calls take, where the device has them: a single one with memory of its own."""
    return tree if platform() == "cpu" or jax.device_count() > 1 else jax.device_put(tree)


def shared_out(
    function: Callable[..., Any], batched: tuple[Any, ...], common: tuple[Any, ...]
) -> Any:
    """`function(*batched, *common)`, each device with its own share of the runs.

    The devices exchange nothing: each goes through its share as it would alone. A batch that cannot be
    shared evenly stays on one device.

    Args:
        function: of trees with the runs along their first axis and of trees that all runs share, to
            trees with the runs first.
        batched: trees of arrays of shape (runs, ...).
        common: trees of arrays that every run takes whole.
    """
    devices = jax.devices()
    runs = jax.tree.leaves(batched)[0].shape[0]
    if len(devices) == 1 or runs % len(devices):
        return function(*batched, *common)
    mesh = Mesh(np.array(devices), ("runs",))
    split, whole = PartitionSpec("runs"), PartitionSpec()
    specs = (*(split for _ in batched), *(whole for _ in common))
    shared = jax.shard_map(function, mesh=mesh, in_specs=specs, out_specs=split, check_vma=False)
    return shared(*batched, *common)
