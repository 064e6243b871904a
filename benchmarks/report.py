"""The report: Markdown tables by name, one JSON file, and the page in docs/ that shows them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks import (
    against,
    cost,
    everything,
    floor,
    gpu,
    headline,
    held_out,
    reference,
    speed_targets,
    studies,
    targets,
    work_precision,
)
from benchmarks.cases import MAIN
from benchmarks.machine import sentence
from benchmarks.native import compare as native
from benchmarks.peers import compare

BLOCK = re.compile(r"(<!-- benchmark ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
FORMAT = 1  # of the JSON file; results of another are not mixed with
KINDS = {"5-ms": "5 ms", "at-once": "at once"}


def tables(data: dict[str, Any]) -> dict[str, str]:
    """Every table that the measured parts allow, by the name of its marker."""
    parts, found = data["parts"], {"machine": sentence(data["machine"]) + "\n" + when(data)}
    if "reference" in parts:
        found |= {f"reference-{k}": v for k, v in reference.tables(parts["reference"]).items()}
    points: Sequence[dict[str, Any]] = parts.get("work-precision", {}).get("points", ())
    others: Sequence[dict[str, Any]] = parts.get("peers", {}).get("points", ())
    if points:
        for key, kind in KINDS.items():
            cases = [c.name for c in MAIN if c.name.endswith(kind)]
            if not any(p["case"] in cases for p in points):
                continue
            found[f"errors-{key}"] = work_precision.table(points, kind)
            found[f"all-{key}"] = everything.table(points, kind)
            for quantity in headline.QUANTITIES:
                name = f"times-{quantity.replace('_', '-')}-{key}"
                found[name] = headline.table(points, quantity, cases)
        found["compile"] = work_precision.compile_table(points)
        found["cut"] = work_precision.cut_off(parts["work-precision"])
        found["targets"] = "\n".join([targets.table(points, others), *speed_targets.rows(parts)])
        found["floor"] = floor.table()
        found["ratios"] = headline.ratios(points, others)
    if "held-out" in parts:
        found["held-out"] = held_out.table(parts["held-out"])
    if others:
        for key, kind in KINDS.items():
            if any(p["case"].endswith(kind) for p in others):
                found[f"peers-{key}"] = compare.table(others, kind)
                found[f"all-peers-{key}"] = everything.others(others, kind)
        found["peers-linear"] = compare.linear_table(others)
        found["against-moordyn"] = against.table(others)
        found["against-settings"] = against.settings_table(others)
        found["moordyn"] = compare.damping_table(others)
        found["readme"] = compare.table(others, "at once", targets.SEGMENTS)
    if "cost" in parts:
        found |= {f"cost-{k}": v for k, v in cost.tables(parts["cost"]).items()}
    if "study" in parts:
        found["study"] = studies.table(parts["study"])
    if "native" in parts:
        found["native"] = native.table(parts["native"])
    if "gpu" in parts:
        found["readme-gpu"] = gpu.sentence(parts["gpu"]["data"])
    for name, part in parts.items():
        if "table" in part:
            found[name] = part["table"]
        if "machine" in part:
            found[name] += f"\n\n{sentence(part['machine'])}"
    return found


def when(data: dict[str, Any]) -> str:
    """When each part was made, and in what time."""
    told = (
        f"{name} {data['made'][name]} ({seconds:.0f} s)"
        for name, seconds in data["seconds"].items()
    )
    return f"Made{' in a quick way' if data['quick'] else ''}, in UTC: {', '.join(told)}."


def filled(page: str, found: dict[str, str]) -> str:
    """The page with every table that was measured; the others stay as they are."""

    def block(match: re.Match[str]) -> str:
        start, name, end = match.groups()
        return f"{start}{found[name]}\n{end}" if name in found else match.group(0)

    return BLOCK.sub(block, page)


def plain(value: Any) -> Any:
    """The same in what JSON knows: NaN and infinities as null."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if hasattr(value, "item"):
        return plain(value.item())
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def restored(value: Any) -> Any:
    """What was read from JSON, null as NaN again."""
    if isinstance(value, dict):
        return {k: restored(v) for k, v in value.items()}
    if isinstance(value, list):
        return [restored(v) for v in value]
    return math.nan if value is None else value


def keep(data: dict[str, Any], folder: Path) -> None:
    """All numbers into a folder, as JSON."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(plain(data), separators=(",", ":")).replace("},{", "},\n{")
    (folder / "results.json").write_text(text + "\n", encoding="utf-8")


def write(data: dict[str, Any], folder: Path) -> dict[str, str]:
    """JSON and tables into a folder."""
    keep(data, folder)
    found = tables(data)
    text = "\n\n".join(f"## {name}\n\n{table}" for name, table in found.items())
    (folder / "tables.md").write_text(f"# Benchmarks\n\n{text}\n", encoding="utf-8")
    return found


def read(folder: Path) -> dict[str, Any] | None:
    """What is in a folder already, None if nothing is."""
    file = folder / "results.json"
    return restored(json.loads(file.read_text(encoding="utf-8"))) if file.exists() else None
