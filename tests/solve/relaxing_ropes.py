"""Materials that relax, as scenes write them, and the law of the paper's nylon."""

import numpy as np
from engine_runs import nylon_rope

BRANCHES = {"fast": (3e5, 0.02), "slow": (2e5, 0.3)}  # N, s


def relaxing(material, branches=BRANCHES):
    """The tables of a material's branches."""
    rows = (
        f"[materials.{material}.relaxation.{name}]\nEA = {stiff}\ntime = {time}\n"
        for name, (stiff, time) in branches.items()
    )
    return "".join(rows)


ROPE = nylon_rope(50, "150 ms").replace("tension_only = false", "tension_only = true")
PARTING = ROPE.replace('"45 kN"', '"180 kN"').replace(
    "[lines.rope]", relaxing("nylon") + "[lines.rope]"
)


NYLON = {"p1": 270.3e3, "p2": 10.2, "p3": -2.128, "p4": 262.7e3, "p5": 135.5}


def nylon(e):
    """The paper's law (N), which is 0.79 kN at a strain of 0."""
    p = NYLON
    return p["p1"] * np.tanh(p["p2"] * e + p["p3"]) + p["p4"] + p["p5"] * e
