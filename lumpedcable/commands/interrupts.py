"""Ctrl-C: the first press ends a command in its own way, the second one at once.

So does SIGTERM, with which schedulers (Slurm, systemd) ask a process to end before they kill it.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["ended_by", "interruptible", "stopped"]

AGAIN = 0.1  # s from an exception that was dropped to the same once more
_seen, _repeats = threading.Event(), threading.Event()
_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
_first = [signal.SIGINT]  # the signal that came first


def ended_by() -> tuple[str, int]:
    """What has ended a command: a word for it, and the exit code that shells give to it."""
    return _WORDS[_first[0]], 128 + _first[0]


def stopped() -> bool:
    """Whether somebody has asked for the end; who asks this ends the command, and is left in peace."""
    _repeats.clear()
    return _seen.is_set()


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt meanwhile, until it is heard; pressed again, it ends the process.
    So does SIGTERM.

    Where it comes while a library runs a callback of the garbage collector, Python reports that
    exception and drops it: it is raised once more.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    report = sys.unraisablehook
    _seen.clear()
    _repeats.clear()
    _first[0] = signal.SIGINT

    def remember(number: int, frame: FrameType | None) -> None:
        if _repeats.is_set():
            _repeats.clear()
        elif _seen.is_set():
            word, code = ended_by()
            os.write(2, f"{word}\n".encode())
            os._exit(code)
        else:
            _first[0] = signal.Signals(number)
        _seen.set()
        raise KeyboardInterrupt

    def repeat() -> None:
        if _repeats.is_set():
            if hasattr(signal, "pthread_kill"):  # which also wakes it up
                signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
            else:
                _thread.interrupt_main()

    def hush(dropped: sys.UnraisableHookArgs) -> None:
        if dropped.exc_type is not KeyboardInterrupt:
            report(dropped)
            return
        _repeats.set()
        timer = threading.Timer(AGAIN, repeat)
        timer.daemon = True
        timer.start()

    before = {number: signal.signal(number, remember) for number in _WORDS}
    sys.unraisablehook = hush
    try:
        yield
    finally:
        _repeats.clear()
        sys.unraisablehook = report
        for number, handler in before.items():
            signal.signal(number, handler)
