"""All cases by name, and all ways of stepping through them."""

from typing import get_args

import mode_cases
import motion_cases
import release_cases
from case import Case

from lumpedcable.scene.run import ADAPTIVE, Method

CASES: dict[str, Case] = {**mode_cases.CASES, **motion_cases.CASES, **release_cases.CASES}

# every way of stepping that the scene language offers
ALL = ("leapfrog", "viscous", "plain", *sorted(set(get_args(Method)) - {"leapfrog"}))

# where rounding to single precision, some 6e-8 EA on every node, is smaller than what a tolerance
# must see to choose a step, and does not add up over Euler's hundreds of thousands of steps
SMALL = ("standing axial wave", "damped axial mode", "body on a heavy line", "body on one segment",
         "shaken end")  # fmt: skip

# whose error has an order in leapfrog's step
STEPPED = [name for name, case in CASES.items() if case.step_order is not None]


def known(name: str, stepping: str, dtype: str) -> bool:
    """Whether this way of stepping finds the answer at all."""
    if stepping == "plain" and not CASES[name].plain:
        return False
    return dtype == "float64" or stepping not in {*ADAPTIVE, "euler"} or name in SMALL


def stuck(name: str, stepping: str) -> bool:
    """Whether this way of stepping ends with a step that it does not find."""
    return name == "free fall" and stepping.startswith("kvaerno")


def excluded() -> str:
    """What of all cases by all ways of stepping is left out, for the page that tells of them."""
    names = list(CASES)
    plain = [name for name in names if not known(name, "plain", "float64")]
    fallen = [name for name in names if any(stuck(name, one) for one in ALL)]
    return "\n".join(
        [
            f"- without wave terms (`waves = \"plain\"`): {', '.join(plain)}, where a chain of lumps "
            "converges to another front;",
            f"- with implicit methods (`kvaerno3` to `kvaerno5`): {', '.join(fallen)}, where such a run "
            "ends with `step_not_found`;",
            "- in single precision with Euler's method or one that chooses its step: all but "
            f"{', '.join(SMALL)}, since rounding hides what a tolerance must see;",
            f"- the order in the step: leapfrog's is found on {len(STEPPED)} of {len(names)} cases, "
            "that of every other integrator on the standing axial wave;",
            "- derivatives in single precision; in double precision they are taken through leapfrog, of "
            "four cases through other integrators or treatments of waves too.",
        ]
    )  # fmt: skip


def options(case: Case, stepping: str, dtype: str = "float64") -> tuple[str, ...]:
    """Overrides that have a case stepped in one of these ways."""
    single = dtype == "float32"
    chosen = [f"solver.dtype={dtype}"] if single else []
    if stepping in ("plain", "viscous"):
        chosen.append(f"solver.waves={stepping}")
    elif stepping == "euler":
        chosen += ["solver.method=euler", f"solver.courant={case.euler}"]
    elif stepping != "leapfrog" and stepping not in ADAPTIVE:
        chosen.append(f"solver.method={stepping}")
    elif stepping in ADAPTIVE:
        # tolerances that the motion of a millimetre, and the precision, can feel
        rtol, atol = (1e-4, 1e-8) if single else (1e-6, 1e-10)
        chosen += [f"solver.method={stepping}", f"solver.rtol={rtol}", f"solver.atol={atol}"]
        # in an interval: what takes more would not end at all; an implicit step is long, and takes long
        implicit = stepping.startswith("kvaerno")
        chosen.append(f"solver.max_steps={20_000 if implicit else 200_000}")
    return tuple(chosen)
