"""What a person sees of natural modes: a table, the titles of a picture, the contents of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from rich.text import Text

import lumpedcable
from lumpedcable.results.human import quantity
from lumpedcable.scene import Scene, Study, format_quantity
from lumpedcable.scene.bodies import ANGLES, Body
from lumpedcable.scene.carried import CarriedBody, WinchEnd, reel_key
from lumpedcable.scene.ends import End
from lumpedcable.solve.modal import Modes
from lumpedcable.solve.modal_coupled import ROUNDING
from lumpedcable.study.tables import console_of, new_table

__all__ = ["conditions", "heading", "modes_contents", "modes_table", "shown"]

MOVES = 0.05  # share of a mode's motion from which an axis is named
DAMPED = 1e-6  # share of critical damping from which it is told
STRONG = 0.2  # the same, from which to first order is not enough
STILL = 1e-6  # of the largest motion: lines that move less do not
UNSETTLED = 0.02  # share of omega^2 in doubt, where K is unsymmetric, from which a mode says so
BLURRED = 1e-3  # share of omega^2 lost in rounding from which a mode says so
TINY = 1e-300
WAYS = ("x", "y", "z", *ANGLES)


def heading(study: Study, run: int) -> str:
    """The scene's title, and which run of its sweep this is."""
    name = study.scene.title or study.path.stem
    return ": ".join(filter(None, [name, _run_values(study, run)]))


def _run_values(study: Study, run: int) -> str:
    if not study.axes:
        return ""
    values = study.runs.values(run)
    return ", ".join(
        f"{axis.label} {format_quantity(values[axis.key], axis.unit)}" for axis in study.axes
    )


def shown(modes: Modes):
    """What is drawn: lines, how they move, a title for each mode, bodies, how those move."""
    outlines = {name: body.outline for name, body in modes.rigid.items()}
    moves = {name: body.shapes for name, body in modes.rigid.items()}
    return modes.nodes, modes.shapes, _titles(modes), outlines, moves


def _titles(modes: Modes) -> list[str]:
    """A short text for each mode: its number, its frequency or what it is instead, which body moves."""
    found = []
    for k, frequency in enumerate(modes.frequency):
        state = _state(modes, k)
        what = f"{frequency:.4g} Hz" if state == "stable" else state
        found.append(", ".join([f"mode {k + 1}: {what}", *_told_moves(modes, k)[:1]]))
    return found


def _state(modes: Modes, k: int) -> str:
    if modes.unstable[k]:
        return "unstable"
    if modes.growth[k] > 0.0:
        return "flutter"
    return "neutral" if modes.neutral[k] else "stable"


def _remark(modes: Modes, k: int) -> str:
    """What is special about a mode, if anything."""
    remarks = []
    if modes.unstable[k]:
        time = quantity(1.0 / float(np.sqrt(-modes.square[k])), "s", 3)
        remarks.append(f"unstable: grows e-fold in {time}")
    elif modes.growth[k] > 0.0:
        time = quantity(1.0 / float(modes.growth[k]), "s", 3)
        remarks.append(f"flutter: grows e-fold in {time}")
    elif modes.neutral[k]:
        remarks.append("neutral: nothing resists it")
    if _state(modes, k) == "stable" and modes.resolution[k] > BLURRED * modes.square[k]:
        share = 50.0 * modes.resolution[k] / modes.square[k]
        remarks.append(f"rounding leaves {share:.1g} % of doubt")
    if modes.damping is not None and modes.damping[k] > STRONG:
        creeps = modes.damping[k] > 1.0
        remarks.append("damped too strongly to swing" if creeps else "strongly damped")
    if modes.doubt[k] > UNSETTLED and not modes.neutral[k]:
        remarks.append("not settled: ask for more modes (-n)")
    return "; ".join(remarks)


def _directions(modes: Modes, k: int) -> list[str]:
    """The axes along which a mode's lines move, the busiest first."""
    motion = np.sum([np.sum(shape[k] ** 2, axis=0) for shape in modes.shapes.values()], axis=0)
    return _busy(WAYS[:3], motion) if np.sum(motion) > STILL**2 else []


def _busy(names: tuple[str, ...], motion: np.ndarray) -> list[str]:
    """The names of what has a part in a motion, the largest first."""
    share = motion / max(np.sum(motion), TINY)
    return [names[c] for c in np.argsort(-share, kind="stable") if share[c] >= MOVES]


def _body_moves(modes: Modes, k: int) -> dict[str, list[str]]:
    """How those bodies and winches move that have a part in a mode, the largest part first."""
    shares = {name: body.share[k] for name, body in modes.rigid.items()}
    shares |= {name: share[k] for name, share in modes.winch_share.items()}
    names = sorted((name for name in shares if shares[name] >= MOVES), key=lambda n: -shares[n])
    return {
        name: _busy(WAYS, modes.rigid[name].ways[k]) if name in modes.rigid else ["payout"]
        for name in names
    }


def _told_moves(modes: Modes, k: int) -> list[str]:
    """The same as texts."""
    return [f"{name}: {', '.join(ways)}" for name, ways in _body_moves(modes, k).items()]


def modes_table(study: Study, run: int, modes: Modes, asked: int) -> None:
    """Print one row a mode, and what a reader should know about all of them."""
    console, table = console_of(), new_table()
    bodies = bool(np.any(modes.bodies > 0.0))
    heads = ["mode", "frequency\n(Hz)", "period\n(s)", "along\nlines (%)", "across\nlines (%)"]
    if damped := _is_damped(modes):
        heads.insert(3, "damping\n(%)")
    for words in [*heads, *(["bodies\n(%)"] if bodies else [])]:
        table.add_column(Text(words), justify="right", vertical="bottom", no_wrap=True)
    rigid = bool(modes.rigid or modes.payout)
    table.add_column(
        Text("lines\nmove in" if rigid else "moves\nin"), vertical="bottom", no_wrap=True
    )
    if rigid:
        table.add_column(Text("bodies\nmove in"), vertical="bottom", no_wrap=True)
    table.add_column(Text("remark"), vertical="bottom")
    *others, remark = range(2, len(table.columns))
    table.spare = [*others[1:], others[0], remark]
    for k, frequency in enumerate(modes.frequency):
        shares = [modes.axial[k], modes.transverse[k], *([modes.bodies[k]] if bodies else [])]
        cells = [
            str(k + 1),
            "-" if np.isnan(frequency) else f"{frequency:.6g}",
            f"{1.0 / frequency:.6g}" if frequency > 0.0 else "-",
            *([_percent(modes, k)] if damped else []),
            *(f"{100.0 * abs(share):.1f}" for share in shares),
            ", ".join(_directions(modes, k)),
            *(["; ".join(_told_moves(modes, k))] if rigid else []),
            _remark(modes, k),
        ]
        table.add_row(*(Text(cell) for cell in cells))
    console.print(Text(heading(study, run), "bold"))
    console.print(table)
    notes = conditions(study, run, modes)
    if len(modes.square) < asked:
        one = modes.unknowns == 1
        notes.insert(1, f"There {'is 1 mode' if one else f'are {modes.unknowns} modes'} in all.")
    if len(study.runs) > 1:
        notes.append(f"Run {run} of 0 to {len(study.runs) - 1}; --run takes another.")
    for note in notes:
        console.print(Text(note, "dim"))


def _is_damped(modes: Modes) -> bool:
    """Whether anything damps small motions."""
    return modes.damping is not None and bool(np.any(modes.damping > DAMPED))


def _percent(modes: Modes, k: int) -> str:
    """A mode's share of critical damping, in percent."""
    assert modes.damping is not None
    share = modes.damping[k] if abs(modes.damping[k]) > DAMPED else 0.0
    return "-" if np.isnan(modes.damping[k]) else f"{100.0 * share:.3g}"


def conditions(study: Study, run: int, modes: Modes) -> list[str]:
    """What a reader should know about all modes: what they are about, and what takes no part."""
    scene = study.runs[run]
    notes = [
        f"Shares are of the kinetic energy. {_plane(modes)}{_damping(scene, modes)}".strip(),
    ]
    if _is_damped(modes):
        notes.append(
            "Damping is the share of the critical one, to first order: good while it is small."
        )
    unstable = int(np.count_nonzero(modes.unstable))
    if unstable:
        count = f"{unstable} mode{'s' if unstable > 1 else ''}"
        notes.append(f"The equilibrium is unstable: {count} shown would grow, not swing.")
    if modes.asymmetry > ROUNDING:
        notes.append(
            f"Drag of a current, or thrust that turns with its body,{_aboard(scene)} makes the "
            f"stiffness unsymmetric (by {modes.asymmetry:.0e} as a whole)."
        )
    if np.any(modes.growth > 0.0):
        notes.append(
            "Flutter: two modes feed each other, in quadrature. The drag of the motion, which is left "
            "out, may hold them: let a run tell."
        )
    if scene.seabed is not None:
        notes.append("What lies on the bed stays on it; what hangs above it does not meet it.")
    if modes.held:
        notes.append(
            f"Not about rest: {modes.held:.4g} N are left on a joint that the scene puts `at` a place."
        )
    for name in _held_bodies(scene):
        notes.append(
            f'"{name}" is held where the scene puts it; with settle = true it comes to rest and moves.'
        )
    return [*notes, *_trolley_notes(scene, modes), *_reel_notes(scene)]


def _trolley_notes(scene: Scene, modes: Modes) -> Iterator[str]:
    """What holds bodies that run on lines."""
    for name, body in scene.bodies.items():
        if not isinstance(body, CarriedBody):
            continue
        if body.height is not None:
            yield f'"{name}" moves about its rest here; the scene lets it go from another height.'
        if body.on.speed is not None:
            yield f'"{name}" is held along its line, as what hauls it does.'
        elif modes.rolling[name] > 0.0:
            force = quantity(modes.rolling[name], "N", 3)
            yield f'"{name}" is held along its line, where {force} would set it going.'
        if body.on.friction is not None and body.on.friction.coefficient > 0.0:
            yield f'Friction, which may keep "{name}" from rolling, takes no part.'


def _reel_notes(scene: Scene) -> Iterator[str]:
    """How winches and drums move."""
    ends = _ends(scene)
    reels = {reel_key(end) for end in ends}
    if "winch" in reels:
        winches = [end.winch for end in ends if isinstance(end, WinchEnd)]
        rubs = [w.sheave is not None and w.sheave.friction * w.sheave.wrap > 0.0 for w in winches]
        if not all(rubs):
            controls = [winch.control for winch in winches]
            integral = any(c is not None and c.integral_time is not None for c in controls)
            told = ", without what their control integrates" if integral else ""
            yield f"Winches pay out and haul in to keep their tension{told}."
        if any(rubs):
            yield "Friction at their sheaves, which small motions do not overcome, holds winches."
    if "drum" in reels:
        yield "Drums are held: each line keeps the length that it has at rest."


def _ends(scene: Scene) -> list[End]:
    """The ends of all lines."""
    return [end for line in scene.lines.values() for end in (line.start, line.end)]


def _aboard(scene: Scene) -> str:
    """What winches on bodies that move do to a stiffness."""
    stand = [end.winch.at for end in _ends(scene) if isinstance(end, WinchEnd)]
    if not any(isinstance(at, str) and at.split(".")[0] in scene.settling for at in stand):
        return ""
    return " or a winch on a body, which gets no lighter by the line that it pays out,"


def _held_bodies(scene: Scene) -> list[str]:
    """Rigid bodies that could move, were they not held while modes are found."""
    rigid = {n: b for n, b in scene.bodies.items() if isinstance(b, Body) and b.rigid}
    return [name for name, body in rigid.items() if not body.settle and body.free != ()]


def _plane(modes: Modes) -> str:
    """Where modes cannot move, because the scene is computed in fewer than three dimensions."""
    d = modes.axes.shape[1]
    if d == 3:
        return ""
    spans = ["xyz"[c] for c in range(3) if np.linalg.norm(modes.axes[c]) > 1.0 - 1e-12]
    what = " and ".join(spans) if len(spans) == d else f"{d} dimensions"
    return f"Motion in {what} only; dimensions = 3 allows all. "


def _damping(scene: Scene, modes: Modes) -> str:
    """What resists the motion and is left out."""
    current = scene.water is not None and scene.water.current is not None
    told, counted = [], _is_damped(modes)
    drag = any(line.drag is not None for line in scene.lines.values())
    damped = [*scene.materials.values(), *([scene.seabed] if scene.seabed is not None else [])]
    damping = modes.damping is None and any(part.damping is not None for part in damped)
    left_out = [word for word, there in (("drag", drag), ("damping", damping)) if there]
    if left_out and not counted:
        told.append(f"Without the {' and '.join(left_out)} of the motion.")
    elif drag and not current:
        told.append("Without drag, which grows with the square of the motion.")
    if any(material.relaxation for material in scene.materials.values()):
        lost = "" if modes.damping is None else ", and lose as much,"
        told.append(f"Materials that relax are as stiff{lost} as at each mode's frequency.")
    return " ".join(told)


def modes_contents(study: Study, run: int, modes: Modes) -> tuple[dict[str, Any], dict[str, Any]]:
    """What goes into the file of natural modes: everything short, and places and shapes by part."""
    table, damping = [], None
    if modes.damping is not None:
        damping = [None if np.isnan(share) else float(share) for share in modes.damping]
    for k, frequency in enumerate(modes.frequency):
        swings = _state(modes, k) in ("stable", "flutter")
        table.append(
            {
                "mode": k + 1,
                "state": _state(modes, k),
                "frequency": float(frequency) if np.isfinite(frequency) else None,
                "period": float(1.0 / frequency) if swings else None,
                "omega_squared": float(modes.square[k]),
                "omega_squared_rounding": float(modes.resolution[k]),
                "growth": float(modes.growth[k]),
                **({} if damping is None else {"damping_ratio": damping[k]}),
                "modal_mass": float(modes.mass[k]),
                "share_along_lines": float(modes.axial[k]),
                "share_across_lines": float(modes.transverse[k]),
                "share_bodies": float(modes.bodies[k]),
                "moves_in": _directions(modes, k),
                **(
                    {"bodies_move_in": _body_moves(modes, k)} if modes.rigid or modes.payout else {}
                ),
                "remark": _remark(modes, k),
            }
        )
    head = {
        "title": study.scene.title,
        "scene": str(study.path),
        "overrides": list(study.overrides),
        "run": run,
        "swept": study.runs.values(run),
        "lumpedcable_version": lumpedcable.__version__,
        "units": {
            "frequency": "Hz", "period": "s", "omega_squared": "rad2/s2", "growth": "1/s",
            "modal_mass": "kg", "position": "m", "shapes": "largest displacement 1",
        },
        "conditions": conditions(study, run, modes),
        "dimensions": modes.axes.shape[1],
        "unknowns": modes.unknowns,
        "stiffness_asymmetry": modes.asymmetry,
        "modes": table,
    }  # fmt: skip
    lines = {
        name: {"position": nodes.tolist(), "shapes": np.round(modes.shapes[name], 12).tolist()}
        for name, nodes in modes.nodes.items()
    }
    parts = {"lines": lines}
    if modes.rigid:
        head["units"]["bodies"] = "x, y, z as shapes; roll, pitch, yaw in rad"
        parts["bodies"] = {
            name: {"position": body.position.tolist(), "shapes": np.round(body.moved, 12).tolist()}
            for name, body in modes.rigid.items()
        }
    if held := {name: force for name, force in modes.rolling.items() if force > 0.0}:
        head["units"]["held_against"] = "N"
        head["held_against"] = held
    if modes.payout:
        head["units"]["winches"] = "m, as shapes"
        parts["winches"] = {
            name: {"shapes": np.round(paid, 12).tolist()} for name, paid in modes.payout.items()
        }
    return head, parts
