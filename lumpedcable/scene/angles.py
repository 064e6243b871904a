"""Angles of which more than a turn, or a few, can only be degrees without their unit."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from lumpedcable.scene.part import Path, Problem

__all__ = ["IN_RADIANS", "TURN", "turn_problems"]

TURN = 2.0 * pi * (1.0 + 1e-9)  # with what conversions of units leave
IN_RADIANS = "a number without a unit is in rad"


def turn_problems(path: Path, angle: float, turns: int = 1) -> Iterator[Problem]:
    """Yield an angle (rad) of more than so many turns: one in degrees that stands without its unit."""
    most = turns * TURN
    if -most <= angle <= most:
        return
    words = "a turn" if turns == 1 else f"{turns} turns"
    yield Problem(
        path,
        f"expected an angle of at most {words} ({most:.3g} rad, {360 * turns} deg) either way, found "
        f"{angle:.6g} rad; {IN_RADIANS}",
    )
