"""Progress where no terminal shows a bar, as under nohup or Slurm: a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from threading import Timer

__all__ = ["now_and_then", "preparing"]

LINES = 10  # at most: one for each tenth of the whole that is done
PAUSE = 60.0  # s from a line to the next, at least
PATIENCE = 20.0  # s without anything done, after which a line tells what takes so long


def now_and_then(title: str, shown: bool) -> Callable[[int, int], None]:
    """What tells of progress on standard error where no bar is shown; a short run gets no line.

    Args:
        title: what each line begins with.
        shown: whether there is a bar; then nothing is told.

    Returns:
        To be called with what is done and all that is to be done, as often as one likes.
    """
    begun = last = time.monotonic()
    told = 0  # tenths
    first: tuple[float, float] | None = None

    def tell(done: int, total: int) -> None:
        nonlocal last, told, first
        now, share = time.monotonic(), done / total if total else 1.0
        # what came before was compiling, or done by an earlier command: neither tells of what is to come
        first = (now, share) if first is None and share > 0.0 else first
        tenths = int(LINES * share + 1e-9)
        if shown or share >= 1.0 or now - last < PAUSE or tenths <= told:
            return
        last, told = now, tenths
        words = f"{100 * share:.0f} % after {_clock(now - begun)}"
        if first is not None and share > first[1]:
            left = (now - first[0]) * (1.0 - share) / (share - first[1])
            words += f", about {_clock(left)} left"
        print(f"{title}: {words}", file=sys.stderr, flush=True)

    return tell


@contextmanager
def preparing(title: str, shown: bool) -> Iterator[Callable[[], None]]:
    """Say once what takes so long where nothing is done yet and no bar tells of it.

    Yields:
        To be called when something is done.
    """
    words = f"{title}: under way; what is compiled now is kept for the next run of such a scene"
    timer = Timer(PATIENCE, print, (words,), {"file": sys.stderr, "flush": True})
    timer.daemon = True
    if not shown:
        timer.start()
    try:
        yield timer.cancel
    finally:
        timer.cancel()


def _clock(seconds: float) -> str:
    """Hours, minutes and seconds, 1:02:03."""
    return str(timedelta(seconds=round(seconds)))
