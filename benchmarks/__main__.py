"""Measures and reports: `python -m benchmarks [PART ...]`; `--help` lists the parts."""

from __future__ import annotations

import argparse
import datetime
import importlib
import os
import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    # what compiling costs is part of the report: nothing is taken from an earlier process; who only
    # imports this leaves the cache to those that he starts
    os.environ["LUMPEDCABLE_CACHE"] = "off"
    # processes that are started beside this one need memory of a GPU as well
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")

from rich.console import Console

from benchmarks import cost, figures, held_out, reference, report, studies, work_precision
from benchmarks.machine import UnableError, absent, describe
from benchmarks.native import compare as native
from benchmarks.peers import compare

Tell = Callable[[str], None]
PARTS: dict[str, Callable[[bool, Tell], dict[str, Any]]] = {
    "reference": reference.run,
    "work-precision": work_precision.run,
    "held-out": held_out.run,
    "peers": compare.run,
    "cost": cost.run,
    "native": native.run,
    "study": studies.run,
}
# what is beside the page's main parts, which know how to run themselves: `run(quick)` and `table(data)`
GUESTS = {
    "hard": "benchmarks.hard",
    "batches": "benchmarks.batches",
    "gradients": "benchmarks.gradients",
    "chain": "benchmarks.peers.moordyn_chain",
    "fit": "benchmarks.fitting",
    "page": "benchmarks.page",
    "rods": "benchmarks.rods",
    "precision": "benchmarks.precision",
    "jobs": "benchmarks.jobs",
    "gpu": "benchmarks.gpu",
    "on-paper": "benchmarks.on_paper",
}
ALONE = {"gpu"}  # compared with nothing on its machine
ROOT = Path(__file__).parents[1]
PAGE, PICTURES = ROOT / "docs" / "benchmarks.md", ROOT / "docs" / "benchmarks"
PAGES = (PAGE, ROOT / "docs" / "benchmarks-all.md", ROOT / "README.md")
OUTPUT = ROOT / "build" / "benchmarks"
LOG_EVERY = 20.0  # s between lines where there is no terminal to write a live one to


def guest(name: str) -> Callable[[bool, Tell], dict[str, Any]] | None:
    """A part that lives in a module of its own, None where there is none."""
    try:
        module = importlib.import_module(GUESTS[name])
    except ImportError:
        return None
    if not hasattr(module, "run") or not hasattr(module, "table"):
        return None

    def part(quick: bool, tell: Tell) -> dict[str, Any]:
        tell(f"{name}, which tells nothing on the way")
        try:
            data = module.run(quick)
        except ModuleNotFoundError as lacks:
            raise UnableError(f"no {lacks.name}: pip install -e '.[test,bench]'") from lacks
        return {"data": data, "table": module.table(data)}

    return part


def parts() -> dict[str, Callable[[bool, Tell], dict[str, Any]]]:
    """Every part by name."""
    found = {name: guest(name) for name in GUESTS}
    return PARTS | {name: part for name, part in found.items() if part is not None}


def measure(name: str, quick: bool, console: Console) -> dict[str, Any]:
    """One part, when it was made and how long that took, with a line that says what is going on."""
    begin, last = time.perf_counter(), 0.0
    with console.status(name) as status:

        def tell(what: str) -> None:
            nonlocal last
            now = time.perf_counter() - begin
            status.update(f"{name}: {what} ({now:.0f} s)")
            if not console.is_terminal and now - last > LOG_EVERY:
                last = now
                console.print(f"  {name}: {what} ({now:.0f} s)")

        found = parts()[name](quick, tell)
    seconds = time.perf_counter() - begin
    console.print(f"{name}: {seconds:.0f} s")
    made = datetime.datetime.now(datetime.UTC).isoformat(" ", "minutes").removesuffix("+00:00")
    return {"parts": {name: found}, "seconds": {name: seconds}, "made": {name: made}}


def joined(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """A part more, or anew, in the usual order."""
    result = dict(old)
    for key, values in new.items():
        both = old.get(key, {}) | values
        result[key] = {name: both[name] for name in parts() if name in both}
    return result


def elsewhere(mine: dict[str, Any], published: dict[str, Any]) -> bool:
    """Whether what is published is of the same kind and size, and of another machine."""
    alike = all(published.get(key) == mine[key] for key in ("format", "quick"))
    return alike and published["machine"] != mine["machine"]


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, write, print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "part",
        nargs="*",
        help=f"what to measure: {', '.join(parts())}; without any: all of them",
    )
    parser.add_argument(
        "--all", action="store_true", help="every part, and an error where one cannot be measured"
    )
    parser.add_argument(
        "--again",
        action="store_true",
        help="only write what is measured already, on whatever machine",
    )
    parser.add_argument("--quick", action="store_true", help="small meshes and few cases")
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT, help="folder to write into")
    parser.add_argument(
        "--docs", action="store_true", help="also fill the two pages of docs/ and README.md"
    )
    asked = parser.parse_args(argv)
    unknown = [name for name in asked.part if name not in parts()]
    if unknown:
        parser.error(f"no such part: {', '.join(unknown)}; there are {', '.join(parts())}")
    names = list(parts()) if asked.all else asked.part or list(parts())
    if asked.again:
        names = []
    console = Console()
    begin = time.perf_counter()
    try:  # what is measured in hours has a place to go to
        asked.output.mkdir(parents=True, exist_ok=True)
        before = report.read(asked.output)
    except OSError as why:
        parser.error(f"-o: expected a folder to write into, found {asked.output}: {why.strerror}")
    except ValueError:
        parser.error(f"-o: expected results of this program in {asked.output}/results.json")
    data = {"format": report.FORMAT, "machine": describe(), "quick": asked.quick}
    # parts that were measured before on this machine, in this size, are kept; what is compared with
    # nothing else may join the pages of another machine, and then tells its own
    here = None
    published = report.read(PICTURES) if asked.docs else None
    before = before or published
    compared = set(names) - ALONE
    if asked.docs and compared and (missing := absent(data["machine"])):
        parser.error(
            f"--docs: expected every program that the pages compare with, found none of "
            f"{', '.join(missing)}: pip install -e '.[bench]'"
        )
    if asked.again:
        if before is None:
            parser.error(f"--again: expected results.json in {asked.output}, found none")
        data = before
    elif before is not None and all(before.get(key) == value for key, value in data.items()):
        data = before  # above all: what is measured here is not to be written over
    elif published is not None and elsewhere(data, published) and set(names) <= set(GUESTS):
        here, data = data["machine"], published
    left_out = {}
    for name in names:
        try:
            data = joined(data, measure(name, asked.quick, console))
        except UnableError as why:  # the others go on
            left_out[name] = why
            continue
        if here is not None:
            data["parts"][name]["machine"] = here
        report.keep(data, asked.output)
    told = "; ".join(f"{name} could not be measured: {why}" for name, why in left_out.items())
    if not data.get("parts"):
        parser.error(told or "expected a part to measure, found none")
    found = report.write(data, asked.output)
    pictures = figures.draw(data["parts"], asked.output)
    for name, table in found.items():
        console.print(f"\n[bold]{name}[/bold]\n")
        console.print(table, markup=False, highlight=False, soft_wrap=True)
    lost = sorted(set(published["parts"]) - set(data["parts"])) if published else []
    if lost:
        parser.error(
            f"--docs: expected all that the pages show from one machine and of one size; measured "
            f"elsewhere, and lost if they were written now: {', '.join(lost)}; -o with another folder "
            "leaves alone what is measured here"
        )
    if asked.docs:
        for file in PAGES:
            page = report.filled(file.read_text(encoding="utf-8"), found)
            file.write_text(page, encoding="utf-8")
        page = PAGE.read_text(encoding="utf-8")
        PICTURES.mkdir(exist_ok=True)
        shown = [picture for picture in pictures if f"({PICTURES.name}/{picture.name})" in page]
        for file in (asked.output / "results.json", *shown):
            shutil.copy(file, PICTURES)
    console.print(f"\n{asked.output}: results.json, tables.md, {len(pictures)} pictures")
    console.print(f"{time.perf_counter() - begin:.0f} s in all")
    if left_out:
        if asked.part or asked.all:  # who names none takes what the machine has
            parser.error(told)
        console.print(told)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        raise SystemExit("interrupted: the parts that were measured are in results.json") from None
