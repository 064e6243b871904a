"""Ctrl-C: the first press ends a command in its own way, the second one at once."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["interruptible", "stopped"]

AGAIN = 0.1  # s from an exception that was dropped to the same once more
_seen, _repeats = threading.Event(), threading.Event()


def stopped() -> bool:
    """Whether Ctrl-C has been pressed; who asks ends the command, and is not interrupted once more."""
    _repeats.clear()
    return _seen.is_set()


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt meanwhile, until it is heard; pressed again, it ends the process.

    Where it comes while a library runs a callback of the garbage collector, Python reports that
    exception and drops it: it is raised once more.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    report = sys.unraisablehook
    _seen.clear()
    _repeats.clear()

    def remember(number: int, frame: FrameType | None) -> None:
        if _repeats.is_set():
            _repeats.clear()
        elif _seen.is_set():
            os.write(2, b"interrupted\n")
            os._exit(130)
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

    before = signal.signal(signal.SIGINT, remember)
    sys.unraisablehook = hush
    try:
        yield
    finally:
        _repeats.clear()
        sys.unraisablehook = report
        signal.signal(signal.SIGINT, before)
