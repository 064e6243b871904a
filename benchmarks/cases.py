"""The cases: four pretensions at two break times, and those that nothing was tuned on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple


class Case(NamedTuple):
    """A parted line: its name in tables, and what it changes in parted-line.toml."""

    name: str
    changes: tuple[str, ...]


def _pulled(kilonewtons: int, break_ms: int, *more: str, name: str = "") -> Case:
    said = f"{kilonewtons} kN, {break_ms} ms" if break_ms else f"{kilonewtons} kN, at once"
    changes = (f"pretension={kilonewtons} kN", f"break.time={break_ms} ms", *more)
    return Case(f"{name}{said}", changes)


PRETENSIONS = (45, 180, 315, 450)  # kN

MAIN = tuple(_pulled(T0, ms) for ms in (5, 0) for T0 in PRETENSIONS)

# another rope: T(0) = 0, steepest at e = 0.107 (264 kN)
STEEPER = (
    "materials.nylon={law='tanh', p1='400 kN', p2=14, p3=-1.5, p4='362059.3 N', p5='50 kN',"
    " tension_only=true}"
)
HOOKE = "materials.nylon={law='linear', EA='1.5 MN', tension_only=true}"

HELD_OUT = (
    *(_pulled(T0, 5) for T0 in (90, 250, 400)),
    *(_pulled(T0, ms) for ms in (2, 20) for T0 in PRETENSIONS),
    *(_pulled(T0, 5, STEEPER, name="another tanh law, ") for T0 in (100, 550)),
    _pulled(150, 5, HOOKE, name="linear law, "),
)


def seen(points: Sequence[dict[str, Any]]) -> tuple[list[str], str]:
    """The main cases that points belong to, and their pretensions (kN) for the head of a table."""
    names = [case.name for case in MAIN if any(p["case"] == case.name for p in points)]
    return names, " / ".join(name.split(" ")[0] for name in names)
