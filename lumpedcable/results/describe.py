"""What a results file holds, as text for a terminal."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from lumpedcable.results.errors import first_line
from lumpedcable.results.folder import HOW_TO_SHOW, StudyFolder, is_study_folder
from lumpedcable.results.human import first_told, quantity, size
from lumpedcable.results.reader import OK, Axis, ResultFile, open_result
from lumpedcable.status import remark_of

_FAILURES_SHOWN = 10


def describe(path: str | Path) -> str:
    """A summary of a results file or study folder: what was run, how, and how far it came.

    Args:
        path: the file, finished or not, or the folder.

    Returns:
        Lines of text, "name   value".

    Raises:
        ResultError: it cannot be read as a results file.
    """
    folder = StudyFolder.open(Path(path)) if is_study_folder(Path(path)) else None
    if folder and not folder.view.exists():  # of a process that was killed as it began
        return _table([*_where(folder), (folder.view.name, f"absent; {HOW_TO_SHOW}")])
    with open_result(folder.view if folder else path) as result:
        rows = [
            ("title", str(result.attributes.get("title", "")) or "(none)"),
            *(_where(folder) if folder else _file(result)),
            ("runs", str(result.runs)),
            *(("swept", _swept(axis)) for axis in result.axes),
            *(("line", _line(result, name)) for name in result.lines),
            ("time", _times(result)),
            ("energy", ", ".join(result.energy_terms) or "not stored"),
            ("solver", _solver(result)),
            ("status", _statuses(result)),
            *_failures(result),
            *_remarks(result),
            *_origin(result),
        ]
    return _table(rows)


def _table(rows: list[tuple[str, str]]) -> str:
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows)


def _file(result: ResultFile) -> list[tuple[str, str]]:
    """Where a results file is, and how far it is."""
    bytes_ = result.path.stat().st_size
    return [("file", f"{result.path}, {size(bytes_)}"), ("state", _state(result))]


def _where(folder: StudyFolder) -> list[tuple[str, str]]:
    """Where a study is, and how far it is."""
    missing = set(folder.missing())
    done = [shard for shard in range(folder.shards) if shard not in missing]
    runs = sum(len(folder.runs(shard)) for shard in done)
    bytes_ = sum(folder.file(shard).stat().st_size for shard in done)
    state = f"{len(done)} of {folder.shards} shards, {runs} of {folder.manifest.runs} runs"
    if not missing:
        state = f"complete: {state}"
    rows = [("folder", f"{folder.path}, {size(bytes_)}"), ("state", state)]
    begun, failures = sorted(missing & set(folder.begun())), folder.failures()
    if begun:
        more = ", ..." if len(begun) > _FAILURES_SHOWN else ""
        rows.append(("begun", f"shards {', '.join(map(str, begun[:_FAILURES_SHOWN]))}{more}"))
    for shard, reason in list(failures.items())[:_FAILURES_SHOWN]:
        rows.append((f"shard {shard}", f"failed: {first_line(reason, 'nobody knows why')}"))
    if len(failures) > _FAILURES_SHOWN:
        rows.append(("", f"and {len(failures) - _FAILURES_SHOWN} more"))
    return rows


def _state(result: ResultFile) -> str:
    if result.complete:
        return "complete"
    count = len(result.time)
    done = int(np.count_nonzero(result.written >= count))
    begun = result.written[(result.written > 0) & (result.written < count)]
    text = f"incomplete: {done} of {result.runs} runs written to the end"
    if begun.size:
        upto = quantity(float(result.time[begun.min() - 1]), "s")
        text += f", {begun.size} up to {upto} or further"
    return text


def _swept(axis: Axis) -> str:
    values = list(dict.fromkeys(float(v) for v in axis.values))
    shown = [quantity(value, axis.unit) for value in values]
    if len(shown) > 8:
        shown = [*shown[:4], "...", *shown[-2:]]
    return f"{axis.key}: {len(values)} values, {', '.join(shown)}"


def _line(result: ResultFile, name: str) -> str:
    line = result.line(name)
    if not line.has("unstretched_position"):
        return f"{name}: {line.nodes} nodes, nothing kept along it"
    lengths = line.unstretched_lengths()
    text = " to ".join(dict.fromkeys(quantity(length, "m") for length in lengths)) + " unstretched"
    if np.isnan(lengths[0]):
        text = "unstretched length not yet known"
    return f"{name}: {line.nodes} nodes, {text}; {', '.join(line.fields)}"


def _times(result: ResultFile) -> str:
    time = result.time
    text = f"{quantity(float(time[0]), 's')} to {quantity(float(time[-1]), 's')}"
    if len(time) > 1:
        text += f" every {quantity(float(np.median(np.diff(time))), 's')}"
    text += f", {len(time)} saved"
    seldom = result.field_time
    if len(seldom) < len(time):
        spacing = quantity(float(seldom[1] - seldom[0]), "s") if len(seldom) > 1 else "once"
        text += f"; fields every {spacing}, {len(seldom)} saved"
    return text


def _solver(result: ResultFile) -> str:
    known = result.attributes
    parts = [str(known.get("solver", "unknown"))]
    step = known.get("step")
    if isinstance(step, (int, float)) and np.isfinite(step):
        parts.append(f"step {quantity(float(step), 's')}")
    elif step is not None and not isinstance(step, (int, float)):
        steps = np.atleast_1d(step)
        low, high = (quantity(float(v), "s") for v in (np.nanmin(steps), np.nanmax(steps)))
        parts.append(f"step {low}" if low == high else f"steps {low} to {high}")
    if "waves" in known:
        parts.append(f"waves {known['waves']}")
    if "dtype" in known:
        parts.append(str(known["dtype"]))
    return ", ".join(parts)


def _statuses(result: ResultFile) -> str:
    # of a file that is not complete nobody knows whether it is still being written
    open_yet = "not at its end" if not result.complete else "interrupted"
    counts = Counter(open_yet if word == "interrupted" else word for word in result.status)
    return ", ".join(f"{count} {word}" for word, count in counts.most_common())


def _failures(result: ResultFile) -> list[tuple[str, str]]:
    words, times, messages = result.status, result.status_time, result.status_message
    failed = [
        run
        for run, word in enumerate(words)
        # a run not yet begun has nothing to say
        if word != OK and (messages[run] or np.isfinite(times[run]))
    ]
    rows = []
    for run in failed[:_FAILURES_SHOWN]:
        when = f" at {quantity(float(times[run]), 's')}" if np.isfinite(times[run]) else ""
        label = result.label(run)
        which = f" ({label})" if label else ""
        rows.append((f"run {run}", f"{words[run]}{when}{which}: {messages[run]}"))
    if len(failed) > _FAILURES_SHOWN:
        rows.append(("", f"and {len(failed) - _FAILURES_SHOWN} more"))
    return rows


def _remarks(result: ResultFile) -> list[tuple[str, str]]:
    """What is to be said of runs that went well."""
    every = enumerate(map(remark_of, result.status_message))
    remarks = ((run, remark) for run, remark in every if remark)
    said, more = first_told(remarks, _FAILURES_SHOWN, "with such a remark")
    return [("remark", words) for words in said] + ([("", more)] if more else [])


def _origin(result: ResultFile) -> list[tuple[str, str]]:
    known = result.attributes
    rows = [("scene", str(known["scene_path"]))] if "scene_path" in known else []
    if known.get("overrides"):
        rows.append(("changed", ", ".join(str(item) for item in known["overrides"])))
    if "created" in known:
        rows.append(("created", str(known["created"])))
    versions = dict(known.get("versions") or {})
    if "lumpedcable_version" in known:
        versions = {"lumpedcable": known["lumpedcable_version"], **versions}
    if versions:
        rows.append(("versions", ", ".join(f"{name} {v}" for name, v in versions.items())))
    return rows
