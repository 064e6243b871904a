"""What the page shows of a results file: fields thinned to a screen, read-outs as they are stored."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.page.bodies import moved_bodies
from lumpedcable.page.curves import largest, length, sag
from lumpedcable.page.pack import Pack
from lumpedcable.page.surroundings import points_apart, surroundings
from lumpedcable.page.thinned import extremes, with_peaks
from lumpedcable.page.unrecorded import StraightLine, Unrecorded
from lumpedcable.results import ResultError
from lumpedcable.results.axes import Axis
from lumpedcable.results.human import quantity, scale
from lumpedcable.results.lines import LineData
from lumpedcable.results.sound import SoundFile
from lumpedcable.results.spread import even

__all__ = ["Payload", "recorded"]

Array = NDArray[Any]

MOST_RUNS = 40
MOST_NODES = 150  # of a line: one every few pixels
MOST_TIMES = 2000  # of the timeline
MOST_NUMBERS = 400_000  # in all histories
MOST_DRAWN = 2_000_000  # numbers of all fields, two bytes each before they are packed


class Payload(dict[str, Any]):
    """The page's head, JSON values, with the block of arrays that it points into."""

    def __init__(self, head: dict[str, Any], pack: Pack) -> None:
        super().__init__(head)
        self.pack = pack


def recorded(path: str | Path, run: int | None = None) -> Payload:
    """Everything that the page of a results file shows: of a run that went wrong what came before.

    Args:
        path: the file, finished or not.
        run: the one that it opens with, shown however many there are; the first if None.

    Returns:
        The head of the page and its arrays. Histories hold the file's numbers as float32; where there
        are more than fit, every so many are left out, and so are runs, but the extremes are kept.

    Raises:
        ResultError: it cannot be read, has no such run, or holds no positions to draw.
    """
    # what has stopped goes on to be seen, where it lies
    with SoundFile.open(path, stops=False) as result:
        result.hold(0 if run is None else run)
        found = _Recorder(result, run or 0)
        if not found.lines:
            raise ResultError(
                f"{path} holds no positions to draw; keep them with quantities = "
                '["position", "tension", ...] and keep = "fields" in [output]'
            )
        return found.payload()


class _Recorder:
    """Reads one file, run by run."""

    def __init__(self, result: SoundFile, first: int) -> None:
        self.result, self.pack, self.first = result, Pack(), first
        runs = even(result.runs, MOST_RUNS)
        # the nearest of the others makes room for the one that is asked for
        runs[np.abs(runs - first).argmin()] = first
        self.runs = runs
        self.scene = result.scene
        self.unrecorded = Unrecorded(result, self.runs, self.scene)
        stored = {name: result.line(name) for name in result.lines}
        self.lines: dict[str, LineData | StraightLine] = {
            **{name: line for name, line in stored.items() if line.has("position")},
            **self.unrecorded.lines,
        }
        self.names = names = list(self.lines)
        self.stored = result.series.histories
        self.motions = result.series.motions
        self.histories = _history_names(self.stored, names, self.motions)
        self.derived: dict[str, dict[str, list[Array]]] = {}
        most = max(MOST_NUMBERS // (len(self.runs) * max(len(self.histories), 1)), 2)
        spread = with_peaks(len(result.time), min(MOST_TIMES, most), self._tensions())
        self.nodes = {name: self._nodes(line) for name, line in self.lines.items()}
        drawn = sum(5 * nodes.size for nodes in self.nodes.values())
        # frames are those of the timeline's times that show fields; what lies between is drawn between
        pool = result.frames if self.seldom else spread
        shown = pool[even(len(pool), min(max(MOST_DRAWN // max(drawn, 1), 20), MOST_TIMES))]
        self.times = np.union1d(spread, shown)
        self.frames = np.searchsorted(self.times, shown)

    def _nodes(self, line: LineData | StraightLine) -> Array:
        """The nodes of a line that are drawn, a row for each run; -1 where a run has no more."""
        kept = [even(line.node_count(int(run)), MOST_NODES) for run in self.runs]
        found = np.full((len(kept), max(map(len, kept))), -1)
        for row, nodes in zip(found, kept, strict=True):
            row[: len(nodes)] = nodes
        return found

    @property
    def seldom(self) -> bool:
        """Whether there are times without fields."""
        return len(self.result.frames) < len(self.result.time)

    def timeline(self, values: Array) -> Array:
        """A history at the times of the timeline; one of the fields' times is straight between two."""
        if len(values) < len(self.result.time):
            return np.interp(self.times, self.result.frames, values)
        return values[self.times]

    def extremes(self, values: Array) -> Array:
        """When (s) and how large a history was at its least and its most, (2, 2)."""
        time = self.result.time
        return extremes(time if len(values) == len(time) else time[self.result.frames], values)

    def _tensions(self) -> Iterator[Array]:
        """Tensions at the ends of lines in the runs that are shown, to be looked at at their peaks."""
        for key in self.stored:
            if key.startswith("lines/") and key.endswith("_tension"):
                yield from (self.result.series.read(key, int(run)) for run in self.runs)

    def payload(self) -> Payload:
        result = self.result
        lines = [self._line(name) for name in self.names]
        scenes = [result.scene_of(int(run)) for run in self.runs]
        around = [surroundings(scene) for scene in scenes]
        times = self.times[self.frames]
        ships = self.unrecorded.ships
        bodies = moved_bodies(result, ships, self.runs, times, scenes, self.pack)
        moved = {body["name"] for body in bodies}
        points = points_apart(around[0]["points"], self.names, moved)
        time = result.time[self.times]
        factor, unit = scale(float(result.time[-1]), "s")
        head = {
            "kind": "recorded",
            "title": str(result.attributes.get("title", "")) or result.path.stem,
            "file": result.path.name,
            "version": str(result.attributes.get("lumpedcable_version", "")),
            "complete": result.complete,
            "time": {"data": self.pack.exact(time), "factor": factor, "unit": unit},
            "times_in_file": len(result.time),
            "frames": self.frames.tolist(),
            "runs": self._runs(),
            "runs_in_file": result.runs,
            "first": int(np.flatnonzero(self.runs == self.first)[0]),
            "axes": self._axes(),
            "lines": lines,
            "histories": self._histories(lines),
            "outputs": self._outputs(),
            "surroundings": [one | {"points": points} for one in around],
            "waves": self._waves(),
            "bodies": bodies,
        }
        return Payload(head, self.pack)

    def _runs(self) -> list[dict[str, Any]]:
        """What sets each run apart, and how it ended."""
        words, messages = self.result.status, self.result.status_message
        times = self.result.status_time
        found = []
        for run in map(int, self.runs):
            when = f" at {quantity(float(times[run]), 's')}" if np.isfinite(times[run]) else ""
            found.append(
                {"number": run, "label": self.result.label(run) or f"run {run}",
                 "status": words[run].replace("_", " ") + when, "message": messages[run]}
            )  # fmt: skip
        return found

    def _axes(self) -> list[dict[str, Any]]:
        """What is swept: names of cases, and numbers that no name stands for."""
        cases = self.result.cases
        named = [{"words": "case", "texts": [cases[run] for run in self.runs]}] if cases else []
        return named + [self._axis(axis) for axis in self.result.axes_apart]

    def _axis(self, axis: Axis) -> dict[str, Any]:
        texts = [quantity(float(axis.values[run]), axis.unit) for run in self.runs]
        return {"words": axis.words, "texts": texts}

    def _waves(self) -> dict[str, Any] | None:
        """Waves of the runs: (run, 4, N) of a, w, k, e as in `Waves`, and what each run has beside."""
        waves = [self.unrecorded.waves.get(int(run)) for run in self.runs]
        if None in waves:
            return None
        shown = [wave for wave in waves if wave is not None]
        sines = [[w.amplitude, w.omega, w.number, w.phase] for w in shown]
        runs = [{"direction": w.direction, "level": w.level, "ramp": w.ramp} for w in shown]
        return {"data": self.pack.exact(sines), "runs": runs}

    # --- fields ----------------------------------------------------------------------------------

    def _line(self, name: str) -> dict[str, Any]:
        """What is drawn of a line: (run, frame, node, 3) places and the like, at its thinned nodes."""
        line, kept = self.lines[name], self.nodes[name]
        fields: dict[str, list[Array]] = {"tension": [], "speed": []}
        drawn: list[Array] = []
        own: dict[str, list[Array]] = {key: [] for key in _DERIVED}
        # one segment between two nodes that are kept
        between = np.where(kept[:, 1:] < 0, -1, (kept[:, :-1] + kept[:, 1:]) // 2)
        places, middles = [], []
        frames = np.searchsorted(self.result.frames, self.times[self.frames])
        for run, nodes, segments in zip(self.runs, kept, between, strict=True):
            position = line.position(int(run))
            drawn.append(_at(position[frames], nodes))
            places.append(_at(line.unstretched_position(int(run))[None], nodes)[0])
            middles.append(_at(line.unstretched_segment(int(run))[None], segments)[0])
            own["length"].append(length(position))
            own["sag"].append(sag(position))
            if line.has("tension"):
                fields["tension"].append(_at(line.tension(int(run))[frames], segments))
            if line.has("velocity"):
                speed = np.linalg.norm(line.velocity(int(run)), axis=-1)
                speed[~self.result.moving[run, self.result.frames]] = np.nan  # it lies
                fields["speed"].append(_at(speed[frames], nodes))
                own["peak_speed"].append(largest(speed))
        self.derived[name] = own
        return {
            "name": name,
            "diameter": self._diameter(name),
            "paid": line.has("payout"),  # its places are those at the start
            "place": self.pack.exact(np.array(places)),
            "middle": self.pack.exact(np.array(middles)),
            # each coordinate over its own range: a small sag of a long line stays smooth
            "position": [self.pack.field(np.array(drawn)[..., k]) for k in range(3)],
            **{key: self.pack.field(values) for key, values in fields.items() if values},
            "scales": {
                key: _scale(np.asarray(values), unit)
                for key, unit, values in (
                    ("tension", "N", fields["tension"]),
                    ("speed", "m/s", fields["speed"]),
                )
                if values
            },
        }

    def _diameter(self, name: str) -> float:
        lines = self.scene.get("lines") or {}
        line = lines.get(name) or lines.get(name.rpartition("-")[0]) or {}
        value = line.get("diameter")
        return float(value) if isinstance(value, int | float) else 0.0

    # --- histories -------------------------------------------------------------------------------

    def _histories(self, lines: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Every number against time: of the lines, of the file, energies."""
        found = []
        for key, (group, words, unit) in self.histories.items():
            if key in self.stored or key in self.motions:
                values = [self.result.series.read(key, int(run)) for run in self.runs]
            else:  # worked out from the fields
                values = self.derived[group].get(key.rpartition("/")[2], [])
            if key in self.motions:
                if not np.any(np.nan_to_num(values)):
                    continue  # it cannot move so
                if "velocity/" in key:
                    values = np.where(self.result.moving[self.runs], values, np.nan)
                values = np.degrees(values) if unit == "deg" else values
            if not len(values):
                continue
            history = {
                "key": key,
                "group": group,
                "words": words,
                **_scale(np.asarray(values), unit),
            }
            history["data"] = self.pack.exact([self.timeline(one) for one in values])
            if len(self.times) < len(self.result.time):
                history["extremes"] = self.pack.exact([self.extremes(one) for one in values])
            found.append(history)
        return _shared_tension(found, lines)

    def _outputs(self) -> list[dict[str, Any]]:
        """The summary's numbers in every run."""
        found = []
        summary = self.result.summary()
        whole = {"run": summary.pop("run")} if "run" in summary else {}
        for end, numbers in (summary | whole).items():
            for name, values in sorted(numbers.items(), key=lambda item: item[0] in _BOOKS):
                known = self.result.summary_attributes(end, name)
                table = np.asarray(values, float)[self.runs]
                words = str(known.get("long_name") or name.replace("_", " "))
                source = known.get("source")
                if not np.isfinite(table).any():
                    continue  # it does not apply to this scene
                found.append(
                    {"key": f"{end}/{name}", "end": "" if end == "run" else end,
                     "name": name, "words": f"{words} ({source})" if source else words,
                     "texts": [_text(value, str(known.get("units", "1"))) for value in table]}
                )  # fmt: skip
        return found


def _at(values: Array, kept: Array) -> Array:
    """Values (times, nodes, ...) at the nodes that are kept, NaN where `kept` is -1."""
    chosen = values[:, kept]
    chosen[:, kept < 0] = np.nan
    return chosen


_BOOKS = ("energy_closure", "solver_step", "solver_steps", "static_imbalance")  # looked at last
_MEGA = 1e7  # N; below, the field says kN
_DERIVED = {
    "length": ("length as stretched", "m"),
    "sag": ("sag below the chord", "m"),
    "peak_speed": ("fastest node", "m/s"),
}


def _history_names(
    stored: dict[str, tuple[str, str]], names: list[str], motions: dict[str, tuple[str, str]]
) -> dict[str, tuple[str, str, str]]:
    """By key: the line or group it belongs to, words, SI unit; those of the lines first."""
    found: dict[str, tuple[str, str, str]] = {}
    for name in names:
        # as one reads a line: its start, then its end
        for key, (words, unit) in sorted(stored.items(), key=lambda item: "/end_" in item[0]):
            if key.startswith(f"lines/{name}/"):
                found[key] = (name, words.removesuffix(" of the line"), unit)
        for key, (words, unit) in _DERIVED.items():
            found[f"lines/{name}/{key}"] = (name, words, unit)
    for key, (body, unit) in motions.items():
        kind, _, quantity, component = key.split("/")
        if kind == "lines":
            side, _, what = quantity.partition("_")
            if body in names:
                found[key] = (body, f"{what} of the {side}, {component}", unit)
        elif quantity in ("position", "attitude"):
            found[key] = (body, f"{body}, {component}", "deg" if unit == "rad" else unit)
    others = {key: value for key, value in stored.items() if not key.startswith("lines/")}
    # energies last: many, and looked at least
    for key in sorted(others, key=lambda key: key.startswith("energy/")):
        group = key.split("/")[-2] if "/" in key else ""
        found[key] = (group, *others[key])
    return found


def _scale(values: Array, unit: str) -> dict[str, Any]:
    """Factor and unit for display, and the largest magnitude, which says how many digits help."""
    good = np.abs(values[np.isfinite(values)])
    top = float(good.max(initial=0.0))
    factor, text = scale(top, unit) if unit != "m" else (1.0, "m")
    return {"factor": factor, "unit": text, "top": top * factor}


def _shared_tension(
    found: list[dict[str, Any]], lines: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """All tensions in one unit, so that they can be compared at a glance."""
    tops = [h["top"] / h["factor"] for h in found if h["unit"].endswith("N")]
    tops += [s["top"] / s["factor"] for li in lines for s in li["scales"].values()
             if s["unit"].endswith("N")]  # fmt: skip
    top = max(tops, default=0.0)
    factor, unit = scale(min(top, 9e5) if top < _MEGA else top, "N")
    for item in (*found, *(s for line in lines for s in line["scales"].values())):
        if item["unit"].endswith("N"):
            item["top"] *= factor / item["factor"]
            item["factor"], item["unit"] = factor, unit
    return found


def _text(value: float, unit: str) -> str:
    if not np.isfinite(value):
        return "–"
    text = quantity(value, unit if unit != "1" else "", 5)
    return re.sub(r"e([+-])0?(\d+)", lambda m: f"·10{_raised(m[1] + m[2])}", text)


def _raised(exponent: str) -> str:
    return exponent.translate(str.maketrans("+-0123456789", "⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹")).removeprefix("⁺")
