"""Where the time of a command goes: seconds by stage, compiling apart; anyone may import it."""

from collections.abc import Iterator
from time import perf_counter

__all__ = ["COMPILE", "Timings", "command_timings"]

COMPILE = "compile"
_loaded = [perf_counter()]  # s: when the package was, which is before all that a command loads


class Timings:
    """Wall time of each stage (s), one after the other without a gap, by the order they ended in.

    Compiling goes on inside of other stages, in any thread: it is taken out of them, so that all stages
    together are the time that has passed.
    """

    def __init__(self, begun: float | None = None):
        self.stages: dict[str, float] = {}
        self._mark = perf_counter() if begun is None else begun
        self._compiled: list[tuple[float, float]] = []

    def mark(self, stage: str) -> None:
        """Book the time since the last mark under `stage`, less what was compiled meanwhile."""
        now, first = perf_counter(), self._mark
        spans, self._compiled, self._mark = self._compiled, [], now
        compiled = union((max(a, first), min(b, now)) for a, b in spans)
        if compiled:
            self.stages[COMPILE] = self.stages.get(COMPILE, 0.0) + compiled
        self.stages[stage] = self.stages.get(stage, 0.0) + now - first - compiled

    def compiled(self, seconds: float) -> None:
        """Learn that something was compiled that took so long (s) and has ended just now."""
        now = perf_counter()
        self._compiled.append((now - seconds, now))

    def lines(self) -> Iterator[str]:
        """A line for each stage and one for all together, for a terminal."""
        for stage, seconds in (*self.stages.items(), ("total", sum(self.stages.values()))):
            yield f"{stage:>10} {seconds:8.2f} s"


def union(spans) -> float:
    """Length of what spans (from, to) cover, which may lie over and inside of each other."""
    covered, reached = 0.0, float("-inf")
    for begin, end in sorted(spans):
        covered += max(end - max(begin, reached), 0.0)
        reached = max(end, reached)
    return covered


def command_timings() -> Timings:
    """Timings of a command that begins: of the first in a process, since it has loaded the package."""
    timings = Timings(_loaded.pop() if _loaded else None)
    timings.mark("start up")
    return timings
