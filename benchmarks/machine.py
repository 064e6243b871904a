"""What the report was measured on."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
from pathlib import Path

import jax

from lumpedcable import __version__

LIBRARIES = (
    "lumpedcable",
    "jax",
    "jaxlib",
    "diffrax",
    "numpy",
    "scipy",
    "numba",
    "moordyn",
    "pyelastica",
)
ABSENT = "not installed"


class UnableError(Exception):
    """A part that this machine lacks something for: what it lacks."""


def absent(machine: dict[str, str]) -> list[str]:
    """The libraries above that a machine does not have, from its description."""
    return [name for name in LIBRARIES if machine[name] == ABSENT]


def describe() -> dict[str, str]:
    """Processor, cores, system, libraries."""
    found = {
        "processor": processor(),
        "cores": str(
            len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
        ),
        "memory": memory(),
        "system": f"{platform.system()} {platform.release().split('-')[0]}",
        "python": platform.python_version(),
        "device": jax.devices()[0].device_kind,
    }
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = ABSENT
    found["lumpedcable"] = __version__  # installed or not
    return found


def processor() -> str:
    """The processor's name, as Linux tells it."""
    file = Path("/proc/cpuinfo")
    text = file.read_text() if file.exists() else ""
    named = re.search(r"model name\s*: (.*)", text)
    return named.group(1) if named else platform.processor() or platform.machine()


def memory() -> str:
    """Main memory."""
    try:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, AttributeError, OSError):
        return "unknown"
    return f"{size / 2**30:.0f} GiB"


def sentence(found: dict[str, str]) -> str:
    """The machine in a sentence."""
    there = [name for name in LIBRARIES if found.get(name, ABSENT) != ABSENT]
    versions = ", ".join(f"{name} {found[name]}" for name in there)
    return (
        f"Measured on {found['processor']} ({found['cores']} cores, {found['memory']}), "
        f"{found['system']}, Python {found['python']}, device {found['device']}, with {versions}."
    )
