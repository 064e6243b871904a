"""Quantities as people write them, "45 kN" or "1025 kg/m3", read into plain SI numbers.

A quantity is a number, a space (optional), and a unit: symbols multiplied by a space, ``*`` or
``·``, divided by ``/``, raised to whole powers by ``3``, ``^3``, ``**3`` or ``³``. Symbols are
case-sensitive (mN is a millinewton, MN a meganewton) and every accepted symbol is listed in a
table, so no prefix is ever glued to something that makes another unit out of it. A product after a
division ("kg/m s") is refused rather than guessed at.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from typing import NamedTuple

G0 = 9.80665
"""Standard gravity in m/s2, which defines kgf, tf and lbf (CGPM 1901)."""


class UnitError(ValueError):
    """A text that is not a quantity, or is one of the wrong dimension.

    The message says what was found, so that it can follow "expected a length (m), found".
    """


class Dimension(NamedTuple):
    """Exponents of kg, m, s and rad. An angle is kept apart from a pure number."""

    kg: int = 0
    m: int = 0
    s: int = 0
    rad: int = 0


class _Unit(NamedTuple):
    factor: float
    dimension: Dimension


_PREFIX = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}
_LENGTH, _MASS, _TIME = Dimension(m=1), Dimension(kg=1), Dimension(s=1)
_FORCE = Dimension(1, 1, -2)
_PRESSURE, _ENERGY, _POWER = Dimension(1, -1, -2), Dimension(1, 2, -2), Dimension(1, 2, -3)
_NUMBER = Dimension()

# symbol: (prefixes it takes, size in SI, dimension)
_TABLE: dict[str, tuple[str, float, Dimension]] = {
    "m": ("n u m c  k", 1.0, _LENGTH),
    "in": ("", 0.0254, _LENGTH),
    "ft": ("", 0.3048, _LENGTH),
    "nmi": ("", 1852.0, _LENGTH),
    "g": ("m  k", 1e-3, _MASS),
    "t": ("", 1e3, _MASS),
    "tonne": ("", 1e3, _MASS),
    "lb": ("", 0.45359237, _MASS),
    "s": ("n u m", 1.0, _TIME),
    "min": ("", 60.0, _TIME),
    "h": ("", 3600.0, _TIME),
    "Hz": ("k", 1.0, Dimension(s=-1)),
    "N": ("u m  k M G", 1.0, _FORCE),
    "kgf": ("", G0, _FORCE),
    "tf": ("", 1e3 * G0, _FORCE),
    "lbf": ("", 0.45359237 * G0, _FORCE),
    "kip": ("", 453.59237 * G0, _FORCE),
    "Pa": ("k M G", 1.0, _PRESSURE),
    "bar": ("", 1e5, _PRESSURE),
    "psi": ("", 0.45359237 * G0 / 0.0254**2, _PRESSURE),
    "J": ("m  k M", 1.0, _ENERGY),
    "W": ("m  k M", 1.0, _POWER),
    "kn": ("", 1852.0 / 3600.0, Dimension(m=1, s=-1)),
    "knot": ("", 1852.0 / 3600.0, Dimension(m=1, s=-1)),
    "knots": ("", 1852.0 / 3600.0, Dimension(m=1, s=-1)),
    "rad": ("m", 1.0, Dimension(rad=1)),
    "deg": ("", math.pi / 180.0, Dimension(rad=1)),
    "°": ("", math.pi / 180.0, Dimension(rad=1)),
    "%": ("", 0.01, _NUMBER),
}

UNITS: dict[str, _Unit] = {
    prefix + symbol: _Unit(_PREFIX[prefix] * size, dimension)
    for symbol, (prefixes, size, dimension) in _TABLE.items()
    for prefix in ["", *prefixes.split()]
}
"""Every symbol that is understood, with its size in SI and its dimension."""

# The text people see for a dimension: name with its article, SI unit.
_NAMES: dict[Dimension, tuple[str, str]] = {
    _NUMBER: ("a number without unit", ""),
    _LENGTH: ("a length", "m"),
    _MASS: ("a mass", "kg"),
    _TIME: ("a time", "s"),
    _FORCE: ("a force", "N"),
    Dimension(rad=1): ("an angle", "rad"),
    Dimension(m=1, s=-1): ("a speed", "m/s"),
    Dimension(m=1, s=-2): ("an acceleration", "m/s2"),
    Dimension(s=-1): ("a frequency", "Hz"),
    Dimension(rad=1, s=-1): ("an angular speed", "rad/s"),
    Dimension(1, -1, 0): ("a mass per length", "kg/m"),
    Dimension(1, -3, 0): ("a density", "kg/m3"),
    Dimension(1, 0, -2): ("a force per length", "N/m"),
    Dimension(1, 1, -1): ("a force times time", "N s"),
    Dimension(1, 0, -1): ("a damping constant", "N s/m"),
    Dimension(m=2, s=-1): ("a kinematic viscosity", "m2/s"),
    Dimension(1, 2, 0): ("a moment of inertia", "kg m2"),
    Dimension(1, 3, -2): ("a bending stiffness", "N m2"),
    Dimension(1, 2, 0): ("a moment of inertia", "kg m2"),
    Dimension(m=2): ("an area", "m2"),
    Dimension(m=3): ("a volume", "m3"),
    _PRESSURE: ("a pressure", "Pa"),
    Dimension(1, -1, -1): ("a viscosity", "Pa s"),
    _ENERGY: ("an energy", "J"),
    _POWER: ("a power", "W"),
}

MINUS = "\N{MINUS SIGN}"  # which word processors and PDF files put in the place of "-"
_NUMBER_TEXT = r"[+-]?(?:\d+(?:_\d+)*(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER_TEXT})(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_TOKEN = re.compile(r"\s*([A-Za-z°%]+)|(?:\*\*|\^)?([+-]?\d+)|\s*([*/()])")
_PLAIN = str.maketrans(
    {"µ": "u", "μ": "u", "·": "*", "⋅": "*", "×": "*", "−": "-"}
    | {sup: f"^{digit}" for sup, digit in zip("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789", strict=True)}
)


def describe(dimension: Dimension) -> str:
    """Return "a force (N)" for a dimension, or its SI unit alone where it has no name."""
    if dimension in _NAMES:
        name, unit = _NAMES[dimension]
        return f"{name} ({unit})" if unit else name
    parts = [f"{s}{p if p != 1 else ''}" for s, p in dimension._asdict().items() if p > 0]
    below = [f"{s}{-p if p != -1 else ''}" for s, p in dimension._asdict().items() if p < 0]
    return "/".join([" ".join(parts) or "1", *below])


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that was probably meant, or None.

    A word that differs by upper and lower case alone comes first, of those the one that differs in the
    fewest letters (for "Mn" MN, not mN), then the closest spelling.
    """
    known = list(known)
    spelt = [candidate for candidate in known if candidate.lower() == word.lower()]
    if spelt:
        return max(spelt, key=lambda c: sum(map(str.__eq__, c, word)))
    close = difflib.get_close_matches(word.lower(), [k.lower() for k in known], n=1, cutoff=0.65)
    return next((k for k in known if k.lower() == close[0]), None) if close else None


def unit_of(text: str, wanted: Dimension | None = None) -> tuple[float, Dimension]:
    """Return the size in SI and the dimension of a unit such as "kN" or "kg/m3".

    Where a ``wanted`` dimension is told, only units of that are suggested for an unknown one.

    Raises:
        UnitError: the text holds an unknown symbol or cannot be read one way only.
    """
    plain = text.translate(_PLAIN).replace("⁻^", "^-")
    tokens, at = [], 0
    while at < len(plain.rstrip()):
        match = _TOKEN.match(plain, at)
        if match is None:
            raise UnitError(f'"{text}", which is not a unit')
        at = match.end()
        tokens.append(match)
    if not tokens:
        return 1.0, _NUMBER
    known = UNITS
    if wanted is not None and len(tokens) == 1:
        known = {word: unit for word, unit in UNITS.items() if unit.dimension == wanted}
    reader = _UnitReader(text, tokens, known)
    try:
        unit = reader.product()
        if not (math.isfinite(unit.factor) and math.isfinite(1.0 / unit.factor)):
            raise OverflowError
    except ArithmeticError:
        raise UnitError(f'"{text}", a unit whose size is beyond arithmetic') from None
    except RecursionError:
        raise UnitError("a unit of more brackets in brackets than can be read") from None
    if reader.at != len(tokens):
        raise UnitError(f'"{text}", which is not a unit')
    return unit.factor, unit.dimension


class _UnitReader:
    """Recursive descent over the tokens of one unit: product := power (('*'|' '|'/') power)*."""

    def __init__(self, text: str, tokens: list[re.Match[str]], meant: Iterable[str]):
        self.text, self.tokens, self.at = text, tokens, 0
        self.meant = meant  # what may be suggested for an unknown symbol

    def operator(self) -> str | None:
        return self.tokens[self.at].group(3) if self.at < len(self.tokens) else None

    def product(self) -> _Unit:
        total, divided = self.power(), False
        while self.at < len(self.tokens) and self.operator() != ")":
            divide = self.operator() == "/"
            if divided and not divide:
                raise UnitError(
                    f'"{self.text}", which can be read two ways: bracket what is below the line'
                )
            divided = divide
            if self.operator() in ("/", "*"):
                self.at += 1
            total = _combine(total, self.power(), -1 if divide else 1)
        return total

    def power(self) -> _Unit:
        base = self.symbol()
        if self.at < len(self.tokens) and self.tokens[self.at].group(2):
            written = self.tokens[self.at].group(2)
            self.at += 1
            digit = written.lstrip("+-0")
            if len(digit) != 1:
                raise UnitError(f'"{self.text}", which has a power outside 1 to 9')
            power = -int(digit) if written.startswith("-") else int(digit)
            return _combine(_Unit(1.0, _NUMBER), base, power)
        return base

    def symbol(self) -> _Unit:
        if self.operator() == "(":
            self.at += 1
            inside = self.product()
            if self.operator() != ")":
                raise UnitError(f'"{self.text}", which has a bracket that is not closed')
            self.at += 1
            return inside
        word = self.tokens[self.at].group(1) if self.at < len(self.tokens) else None
        if word is None:
            raise UnitError(f'"{self.text}", which is not a unit')
        if word not in UNITS:
            guess = nearest(word, self.meant)
            raise UnitError(
                f'unknown unit "{word}"' + (f'; did you mean "{guess}"?' if guess else "")
            )
        self.at += 1
        return UNITS[word]


def _combine(a: _Unit, b: _Unit, power: int) -> _Unit:
    dimension = Dimension(*(x + power * y for x, y in zip(a.dimension, b.dimension, strict=True)))
    return _Unit(a.factor * b.factor**power, dimension)


def split_quantity(text: str) -> tuple[float, str]:
    """Split "45 kN" into 45.0 and "kN" (the unit may be empty).

    Raises:
        UnitError: the text does not start with a finite number.
    """
    match = _QUANTITY.fullmatch(text.replace(MINUS, "-"))
    if match is None:
        raise UnitError(f'"{text}", which does not start with a number')
    value = float(match.group(1))
    if not math.isfinite(value):
        raise UnitError(f'"{text}", which is not finite')
    return value, match.group(2)


def parse_quantity(text: str, unit: str) -> float:
    """Return the SI value of a text, which must have the dimension of ``unit``.

    >>> parse_quantity("45 kN", "N")
    45000.0

    Raises:
        UnitError: no number, not finite, an unknown unit or another dimension.
    """
    value, written = split_quantity(text)
    expected = unit_of(unit)[1]
    factor, found = unit_of(written, expected)
    if found != expected:
        if not written:
            raise UnitError(f'"{text}", which has no unit')
        hint = ""
        if (expected, found) == (_FORCE, _MASS):
            hint = f'; did you mean "{value:g} {"kgf" if factor <= 1 else "tf"}"?'
        raise UnitError(f'{describe(found)}, "{text}"{hint}')
    # 5 / 1000 and 5 * 0.001 differ in the last bit: divide where the factor is one over an integer.
    whole = round(1.0 / factor)
    si = value / whole if factor < 1.0 and 1.0 / whole == factor else value * factor
    if not math.isfinite(si):
        raise UnitError(f'"{text}", which is not finite')
    return si


# Leading symbol: prefixes used to print it, smallest first.
_PRINTED = {"N": "um kMG", "Pa": "  kMG", "J": "m kM", "W": "m kM", "m": "um k", "s": "num"}


def format_quantity(value: float, unit: str, digits: int = 6) -> str:
    """Return a short text for a value in SI: 45e3 in "N" gives "45 kN", 0.005 in "s" gives "5 ms".

    Metres and seconds take a prefix on their own only (never in m3 or m/s); angles are in degrees.
    """
    if unit == "rad":
        value, unit = math.degrees(value), "deg"
    if not math.isfinite(value):
        return f"{value} {unit}".strip()
    lead = unit.split(" ")[0].split("/")[0]
    scalable = lead in _PRINTED and (lead not in ("m", "s") or unit == lead)
    if not scalable or value == 0:
        return f"{_rounded(value, digits)} {unit}".strip()
    prefixes = [p.strip() for p in _PRINTED[lead]] + ([""] if lead == "s" else [])
    chosen = prefixes[0]
    for prefix in prefixes:
        # Judge the rounded number, so that 999.9999999 N is printed as 1 kN.
        if abs(float(f"{value / _PREFIX[prefix]:.{digits}g}")) >= 1:
            chosen = prefix
    return f"{_rounded(value / _PREFIX[chosen], digits)} {chosen}{unit}"


def _rounded(value: float, digits: int) -> str:
    """A number to so many digits, written out below a million: 130, not 1.3e+02."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+0" in text and abs(value) < 999999.5 else text
