"""All cases by name, and all ways of stepping through them."""

from typing import get_args

import mode_cases
import motion_cases
import release_cases
from case import Case

from lumpedcable.scene.run import Method
from lumpedcable.study.plan import ADAPTIVE

CASES: dict[str, Case] = {**mode_cases.CASES, **motion_cases.CASES, **release_cases.CASES}

# every way of stepping that the scene language offers
ALL = ("leapfrog", "viscous", "plain", *sorted(set(get_args(Method)) - {"leapfrog"}))


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
