"""Peak speeds of broken ends above what the exact wave allows, which a mesh too coarse gives."""

from __future__ import annotations

import numpy as np

from lumpedcable.exact import ReleaseWave
from lumpedcable.results.human import quantity
from lumpedcable.scene import Scene
from lumpedcable.scene.ends import held_place

__all__ = ["EXCESS", "allowance", "excess_words"]

EXCESS = 0.05
"""Share by which a peak speed may exceed the exact one before anything is said."""


def allowance(scene: Scene, line: str, length: float, wave: ReleaseWave, begins: float) -> float:
    """Speed (m/s) that weight may add to the exact end speed of a line that breaks at `begins` (s).

    inf where the exact speed is no upper bound for other reasons. It is one of a line between ends that
    stay where they are, alone in the scene and pulled by nothing that moves, on no bed: the end is then
    fastest behind the first front, since drag, damping and a slower break take speed from it, and what
    comes back from the far end adds none as long as the law is a straight line or cannot push. Of other
    laws it is one until that comes back. Weight less buoyancy, w in N/m of what the wave moves, m in
    kg/m, adds w t / m in the time t that is left, as long as it is little beside the tension.

    Args:
        scene: the scene of the run.
        line: the line that breaks, `length` (m) of it on the side of the end that recoils.
        wave: its exact wave.
        begins: when the break begins, s.
    """
    own = scene.lines[line]
    broken = [event.target()[1] for event in scene.events.values()]
    far = [end for side, end in (("start", own.start), ("end", own.end)) if side not in broken]
    still = all(held_place(end) is not None for end in far)
    current = scene.fluid is not None and scene.fluid.current is not None
    moved = current or scene.sea is not None or scene.seabed is not None or bool(scene.bodies)
    if not still or moved or len(scene.lines) > 1 or len(broken) > 1:
        return np.inf
    if scene.solver.waves == "plain" or scene.materials[own.material].law == "inextensible":
        return np.inf  # which overshoot on any mesh, or have no wave
    material, left = scene.materials[own.material], scene.output.duration - begins
    goes_back = material.law == "linear" or material.tension_only
    if not (goes_back or left <= wave.reflection_return(length)):
        return np.inf
    per_metre = (scene.gravity or 0.0) * abs(own.mass - scene.displaced(line))
    more, weight = per_metre / wave.mass * max(left, 0.0), per_metre * own.unstretched
    if weight > EXCESS * wave.tension0 or more > EXCESS * wave.end_speed:
        return np.inf
    return more


def excess_words(
    end: str, peak: float, exact: float, more: float, sudden: tuple[str, float] | None = None
) -> str:
    """What is said of a peak speed (m/s) beside the exact one and what weight may add; "" of nothing.

    `sudden` is the event that breaks the end and its time (s), where that is less than the wave takes
    in a segment.
    """
    if not peak > (1.0 + EXCESS) * exact + more:
        return ""
    share = f"{100.0 * (peak / exact - 1.0):.0f} %"
    event, takes = sudden or ("", np.inf)
    advice = "take more segments"
    if takes == 0.0:
        advice = (
            "a break at once overshoots at first on any mesh: give "
            f"events.{event}.time what it takes, or read the speed from its history"
        )
    elif sudden is not None:
        so_short = f"events.{event}.time, {quantity(takes, 's')}"
        advice = f"the wave takes longer through a segment than {so_short}: {advice}"
    return f"peak end speed of {end} is {share} above the exact bound: {advice}"
