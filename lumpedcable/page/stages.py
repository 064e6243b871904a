"""A highline's stages on the live page, in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lumpedcable.exact import STAGES, StageShape, stage_shape
from lumpedcable.exact.checks import NO_LINE
from lumpedcable.exact.stages import UNITS
from lumpedcable.page.controls import Control, FaultError, Model
from lumpedcable.page.drawn import NO_SHAPE, drawn_line, shown_number

__all__ = ["stage_models"]

WORDS = {
    "S": "length S",
    "S_traction": "length of the traction cable",
    "f": "deflection f",
    "F_TA": "tension at the sending end, F_TA",
    "F_TB": "tension at the receiving end, F_TB",
    "F_H": "horizontal tension F_H",
}
_GRAVITY = 9.81  # m/s2, of a scene that is saved
_POINTS = 201
_REMARK = "closed form of an inextensible line"
_STIFF = 1e3  # stiffness over tension of a saved line


def stage_models(numbers: Mapping[str, float]) -> list[Model]:
    """All stages of a highline as models for the page, starting from these numbers."""
    return [_model(key, numbers) for key in STAGES]


def _model(key: str, numbers: Mapping[str, float]) -> Model:
    stage = STAGES[key]
    controls = []
    for name, slider in stage.sliders.items():
        value = numbers.get(name, slider.value)
        # a scene's own number may lie beyond what is usual
        low, high = min(slider.low, value), max(slider.high, value)
        if name == "place":
            span = numbers.get("span", stage.sliders["span"].value)
            low, high = 0.02 * span, 0.98 * span
        controls.append(Control(name, "", slider.words, slider.unit, value, low, high))

    own = {control.key: control.value for control in controls}

    def solve(values: dict[str, float]) -> dict[str, Any]:
        with np.errstate(all="ignore"):  # what comes of it is looked at
            return _answer(_shape(key, _POINTS, own | values))

    def toml(values: dict[str, float]) -> str:
        every = own | values
        with np.errstate(all="ignore"):
            return _scene(stage.words, every, _shape(key, 4001, every))

    return Model(key, stage.words, controls, solve, toml, _REMARK)


def _shape(key: str, points: int, values: Mapping[str, float]) -> StageShape:
    try:
        return stage_shape(key, points=points, **values)
    except ValueError as error:
        raise FaultError(str(error)) from error
    except ArithmeticError as error:  # of Python's own numbers, whose words tell a reader nothing
        raise FaultError(NO_LINE) from error


def _answer(shape: StageShape) -> dict[str, Any]:
    lines = [_line("highline", shape)]
    near = shape.approximate
    if near is not None:
        lines.append({**_line("straight segments", near), "second": True})
    other = near.numbers if near is not None else {}
    rows = [
        shown_number(key, WORDS[key], value, UNITS[key], other.get(key))
        for key, value in shape.numbers.items()
    ]
    points = (
        [{"name": shape.mark_words, "at": [shape.mark[0], 0.0, shape.mark[1]]}]
        if shape.mark
        else []
    )
    return {"lines": lines, "points": points, "numbers": rows, "equations": list(shape.equations)}


def _line(name: str, shape: StageShape) -> dict[str, Any]:
    """The line with its tension H ds/dx between its points."""
    position = np.column_stack([shape.x, np.zeros_like(shape.x), shape.z])
    step = np.diff(position, axis=0)
    keep = np.append(True, step[:, 0] > 0.0)  # the load's place may fall on a point
    position = position[keep]
    step = np.diff(position, axis=0)
    long = np.linalg.norm(step, axis=1)
    tension = shape.numbers["F_H"] * long / step[:, 0]
    ends = [shape.numbers["F_TA"], shape.numbers["F_TB"]]
    return drawn_line(name, position, tension, np.cumsum(long) - 0.5 * long, ends, long.sum())


def _scene(words: str, values: Mapping[str, float], shape: StageShape) -> str:
    """A scene of the line as it hangs, practically inextensible, for `lumpedcable run`."""
    x, z = shape.x, shape.z
    cut = len(x) - 1 if shape.split is None else shape.split - 1
    stiff = _STIFF * max(shape.numbers["F_TA"], shape.numbers["F_TB"])
    long = np.hypot(np.diff(x), np.diff(z))
    # the tension is H ds/dx; the lengths before it stretches them, so that it hangs where it should
    rest = long / (1.0 + shape.numbers["F_H"] / stiff * (long / np.maximum(np.diff(x), 1e-12)))
    rest = np.where(np.diff(x) > 0.0, rest, 0.0)
    weights = [values["weight"], values.get("traction_weight", values["weight"])]
    lengths, masses = [], []
    for part, weight in zip((slice(cut), slice(cut, None)), weights, strict=True):
        lengths.append(float(rest[part].sum()))
        whole = float(long[part].sum())
        masses.append(weight / _GRAVITY * (whole / lengths[-1] if lengths[-1] else 1.0))
    if not np.isfinite([stiff, *lengths, *masses]).all():
        raise FaultError(NO_SHAPE)
    ends = [[0.0, 0.0, 0.0], [float(x[-1]), 0.0, float(z[-1])]]
    head = [
        f"# {words}, as Lun, Li & Hou (2018) have it. Their cable is inextensible; this one",
        f"# stretches by 1/{_STIFF:g} at most: EA is no property of a real cable, and the lengths are",
        "# those before it stretches.",
        f'title = "Highline: {words.lower()}"',
        f'gravity = "{_GRAVITY:g} m/s2"',
        "", "[materials.cable]", 'law = "linear"', f'EA = "{stiff:.9g} N"',
    ]  # fmt: skip
    load = values.get("load")
    middle = "cargo" if load is not None else "traction.start"
    if load is not None:
        head += ["", "[bodies.cargo]", f'mass = "{load / _GRAVITY:.9g} kg"',
                 f"position = {list(_place(shape))}"]  # fmt: skip
    names = ["highline"] if shape.mark is None else ["highline", "onward" if load else "traction"]
    for k, name in enumerate(names):
        first, last = k == 0, k == len(names) - 1
        start = f"{{ fixed = {ends[0]} }}" if first else f'"{middle if load else "highline.end"}"'
        end = f"{{ fixed = {ends[1]} }}" if last else f'"{middle}"'
        head += [
            "", f"[lines.{name}]", 'material = "cable"', f'length = "{lengths[k]:.9g} m"',
            "segments = 50", f'mass = "{masses[k]:.9g} kg/m"',
            f"start = {start}", f"end = {end}",
        ]  # fmt: skip
    head += ["", "[output]", 'duration = "10 s"', 'every = "0.1 s"']
    return "\n".join(head) + "\n"


def _place(shape: StageShape) -> tuple[float, float, float]:
    assert shape.mark is not None
    return round(shape.mark[0], 6), 0.0, round(shape.mark[1], 6)
