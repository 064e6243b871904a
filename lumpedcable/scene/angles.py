"""Angles that say which way something points: no more than a turn."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from lumpedcable.scene.part import Path, Problem

__all__ = ["turn_problems"]

TURN = 2.0 * pi * (1.0 + 1e-9)  # with what conversions of units leave


def turn_problems(path: Path, angle: float) -> Iterator[Problem]:
    """Yield an angle (rad) of more than a turn: one in degrees that stands without its unit."""
    if -TURN <= angle <= TURN:
        return
    yield Problem(
        path,
        "expected an angle of at most a turn (6.28 rad, 360 deg) either way, found "
        f"{angle:.6g} rad; a number without a unit is in rad",
    )
