"""The hard cases: result against N, energy residual, the largest stable step, time.

`python -m benchmarks.hard` prints the table; --out FOLDER writes it with its numbers as JSON, --docs
puts it into docs/hard-cases.md.
"""

from __future__ import annotations

import argparse
import json
import platform
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.hard_cases import CASES, FOLDER, Case, Ran, run_case
from lumpedcable.model.numbers import number
from lumpedcable.scene import Study, load_study
from lumpedcable.status import Status
from lumpedcable.study.compiled import prepare_batch
from lumpedcable.study.plan import common_coordinates, structure_of

PAGE = Path(__file__).parents[1] / "docs" / "hard-cases.md"
BREAK_SIZES = (50, 100, 200, 400, 800, 1600, 3200, 6400)  # of break-at-once

# a step is called stable where the run ends as expected, energy closes to 1 % of what was released
# and the largest speed is within a quarter of that with half the bound
CLOSURE, SPEED = 0.01, 0.25
HALF, MOST = 0.5, 0.99  # at the bound itself rounding decides
RESOLUTION = 0.02


def step_bound(study: Study) -> float:
    """The largest stable step (s) that the model claims for the one scene of a study."""
    scene = study.runs[0]
    structure = structure_of(scene)
    coordinates = common_coordinates(study, [scene])
    shared = {key: number(value) for key, value in scene.numbers().items()}
    swept = {"output.duration": jnp.asarray([shared.pop("output.duration")])}
    ready = prepare_batch(
        structure, scene.solver.dtype, coordinates.axes, coordinates.origin, shared, swept
    )
    return float(ready.bound[0])


def at_courant(case: Case, size: int, share: float) -> Ran:
    """A case with steps of exactly `share` of the bound, outputs as near to its own as that allows."""
    changes = case.sized(size)
    study = load_study(FOLDER / f"{case.name}.toml", list(changes))
    output, step = study.runs[0].output, share * step_bound(study)
    steps = max(1, round(output.every / step))
    unit = max(1, 2 ** (int(np.log2(steps)) - 4))  # the engine takes numbers of five bits
    every = unit * max(1, round(steps / unit)) * step
    count = max(1, round(output.duration / every))
    given = (
        f"solver.courant={share!r}",
        f"output.every={every!r}",
        f"output.duration={count * every!r}",
    )
    return run_case(case.name, *changes, *given)


def is_stable(case: Case, ran: Ran, speed: float) -> bool:
    """Whether a run ended as it should, kept its energy and its largest speed (m/s)."""
    outcome = ran.outcome
    return (
        outcome.status is case.status
        and outcome.energy_closure <= CLOSURE
        and abs(ran.top_speed() - speed) <= SPEED * speed
    )


def largest_stable(case: Case, size: int, resolution: float) -> float:
    """Largest share of the step bound, up to MOST, that is stable; NaN where half of it is not."""
    half = at_courant(case, size, HALF)
    speed = half.top_speed()
    if not is_stable(case, half, speed):
        return float("nan")
    low, high = HALF, MOST
    if is_stable(case, at_courant(case, size, high), speed):
        return high
    while high - low > resolution:
        middle = 0.5 * (low + high)
        if is_stable(case, at_courant(case, size, middle), speed):
            low = middle
        else:
            high = middle
    return low


def measured(case: Case, size: int) -> dict[str, Any]:
    """One size with the scene's own step: values, energy residual, warm time."""
    changes = case.sized(size)
    run_case(case.name, *changes)  # compiles
    started = time.perf_counter()
    ran = run_case(case.name, *changes)
    seconds = time.perf_counter() - started
    outcome = ran.outcome
    return {
        "segments": size,
        "status": outcome.status.name,
        "status_time": outcome.status_time,
        "expected": case.status.name,
        "values": case.measure(ran),
        "energy_residual": outcome.energy_closure,
        "steps": outcome.steps,
        "step": outcome.solver_step,
        "seconds": seconds,
    }


def run(quick: bool) -> dict[str, Any]:
    """Every case at N/2, N and 2 N, its largest stable step at N/2 and N; quick: N/2 alone, coarsely."""
    cases: dict[str, Any] = {}
    for index, case in enumerate(CASES):
        print(f"\rhard cases {index + 1}/{len(CASES)}: {case.title:40}", end="", file=sys.stderr)
        sizes: Sequence[int] = (case.segments // 2, case.segments, 2 * case.segments)
        if quick:
            sizes = sizes[:1]
        elif case.name == "break-at-once":
            sizes = BREAK_SIZES
        runs = [measured(case, size) for size in sizes]
        coarse = 0.25 if quick else RESOLUTION
        for own in runs:
            searched = own["segments"] in (case.segments // 2, case.segments)
            own["stable_courant"] = (
                largest_stable(case, own["segments"], coarse) if searched else None
            )
        cases[case.name] = {
            "title": case.title,
            "segments": case.segments,
            "exact": case.exact(),
            "runs": runs,
        }
    print(file=sys.stderr)
    return {
        "quick": quick,
        "machine": {
            "processor": platform.processor() or platform.machine(),
            "system": platform.platform(),
            "device": jax.devices()[0].device_kind,
        },
        "limits": {"energy_residual": CLOSURE, "speed": SPEED, "most": MOST},
        "cases": cases,
    }


def _number(value: float, digits: int = 5) -> str:
    return "-" if not np.isfinite(value) else f"{value:.{digits}g}"


def _off(value: float, exact: float) -> str:
    """The error in per cent, of a value whose exact one is not zero."""
    if exact == 0.0 or not np.isfinite(value):
        return ""
    return f" ({100.0 * (value / exact - 1.0):+.2g} %)"


def _courant(found: float | None) -> str:
    """The largest stable Courant number in words; nothing where it was not looked for."""
    if found is None:
        return ""
    if not np.isfinite(found):
        return "below 0.5"
    return f"{found:.2f} (all)" if found == MOST else f"{found:.2f}"


def table(data: dict[str, Any]) -> str:
    """Two Markdown tables: what was found against N, and how far the step can go."""
    found = ["| case | result | exact | N | found (error) |", "|---|---|---|---|---|"]
    for case in data["cases"].values():
        for name, exact in case["exact"].items():
            for run_ in case["runs"]:
                value = run_["values"][name]
                first = run_ is case["runs"][0]
                title = case["title"] if first and name == next(iter(case["exact"])) else ""
                label, right = (name, _number(exact, 6)) if first else ("", "")
                told = _number(value, 6 if exact else 3) + _off(value, exact)
                found.append(f"| {title} | {label} | {right} | {run_['segments']} | {told} |")
    steps = [
        "| case | N | ends as | energy residual, % of the released | largest stable Courant number"
        " | steps | time, s |",
        "|---|---|---|---|---|---|---|",
    ]
    for case in data["cases"].values():
        for run_ in case["runs"]:
            status = Status[run_["status"]].name.lower().replace("_", " ")
            if run_["status"] != run_["expected"]:
                status = f"**{status}**"
            told = _courant(run_["stable_courant"])
            first = run_ is case["runs"][0]
            cells = (
                case["title"] if first else "", run_["segments"], status,
                _number(100.0 * run_["energy_residual"], 2), told,
                run_["steps"], _number(run_["seconds"], 2),
            )  # fmt: skip
            steps.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(found) + "\n\n" + "\n".join(steps) + "\n"


def written(page: str, data: dict[str, Any]) -> str:
    """A page with the table between its markers."""
    machine = ", ".join(data["machine"][key] for key in ("device", "system"))
    block = f"<!-- hard cases -->\nOn {machine}:\n\n{table(data)}<!-- end -->"
    new, count = re.subn(
        r"<!-- hard cases -->.*?<!-- end -->", lambda _: block, page, flags=re.DOTALL
    )
    if count != 1:
        raise ValueError(f"expected one place for the table of hard cases, found {count}")
    return new


def main(argv: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hard", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer sizes, steps only coarsely")
    parser.add_argument("--out", type=Path, help="folder for hard.md and hard.json")
    parser.add_argument("--docs", action="store_true", help="put the tables into the page")
    options = parser.parse_args(argv)
    data = run(options.quick)
    text = table(data)
    print(text)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "hard.md").write_text(text)
        (options.out / "hard.json").write_text(json.dumps(data, indent=1) + "\n")
    if options.docs:
        PAGE.write_text(written(PAGE.read_text(), data))
    return 0


if __name__ == "__main__":
    sys.exit(main())
