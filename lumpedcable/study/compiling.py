"""Hears from jax what it compiles, for timings."""

from collections.abc import Iterator
from contextlib import contextmanager

from jax import monitoring

from lumpedcable.timings import Timings

__all__ = ["heard"]

# following the Python code, writing it down for the compiler, compiling or fetching from the cache; each
# may be told inside of another
EVENTS = "/jax/core/compile/"


@contextmanager
def heard(timings: Timings) -> Iterator[None]:
    """Book meanwhile what jax takes to come by compiled programs, in whichever thread."""

    def hear(event: str, duration_secs: float, **kwargs: str | int) -> None:
        if event.startswith(EVENTS):
            timings.compiled(duration_secs)

    monitoring.register_event_duration_secs_listener(hear)
    try:
        yield
    finally:
        monitoring.unregister_event_duration_listener(hear)
