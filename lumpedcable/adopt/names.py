"""What the words of an input file of MoorDyn mean: kinds of points, numbers of things, options."""

from __future__ import annotations

import re
from collections.abc import Container

__all__ = ["KINDS", "OWN", "TAKEN", "WATER", "WEIGHTY", "bare", "body_of"]

FIXED, COUPLED = ("fix", "fixed", "anchor"), ("vessel", "coupled", "fairlead", "ves", "cpld")
FREE = ("connect", "con", "free", "point")
KINDS = (
    dict.fromkeys(FIXED, "fixed") | dict.fromkeys(COUPLED, "coupled") | dict.fromkeys(FREE, "free")
)
POINT = r"(?i)^(p(oint)?|c(on(nect(ion)?)?)?)(?=\d)"  # before the number of a point
WEIGHTY = ("rho", "rhow", "wtrdnsty", "wtrdens", "g", "gravity", "kbot", "kb")  # positive
TAKEN = (*WEIGHTY, "cbot", "cb", "frictioncoefficient", "wtrdpth")
# options of MoorDyn's own stepping, start and output, of which a scene has nothing
OWN = (
    "dtm", "dt", "tscheme", "writelog", "writeunits", "dtic", "icdt", "tmaxic", "ictmax", "cdscaleic",
    "icdfac", "threshic", "icthresh", "icgendynamic", "icgenstationary", "icstationary", "dtout",
    "outswitch", "disableouttime", "disableoutput", "fricdamp", "statdynfricscale", "dtwave", "echo",
    "cfl",
)  # fmt: skip
# options whose place in a scene is another one, by what to do about it
WATER = {
    "wavekin": "give a scene its waves",
    "currents": "give a scene its current",
    "waterkin": "give a scene its current and waves",
    "seafloorfile": "give the bed a profile",
}


def body_of(kind: str, bodies: Container[str]) -> str:
    """The body that something is on, "" where it is on none that there is."""
    named = re.fullmatch(r"(?i)body0*(\d+)", kind)
    return named[1] if named and named[1] in bodies else ""


def bare(point: str) -> str:
    """The number of a point, which may be named P1, Point1, C1 or Con1; R1A of the end of a rod."""
    rod = re.fullmatch(r"(?i)r(?:od)?(\d+)([ab])", point)
    return f"R{rod[1]}{rod[2].upper()}" if rod else re.sub(POINT, "", point)
