"""The base of everything that a scene holds, and the choice between kinds of a thing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple
from unicodedata import category

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    StringConstraints,
)

from lumpedcable.scene.quantities import NAME_PATTERN, fault, found
from lumpedcable.scene.units import nearest

Path = tuple[str | int, ...]
"""Where a value stands: ("lines", "rope", "end", "held", "pretension")."""
SIDES = ("start", "end")
"""The ends of a line."""


class Problem(NamedTuple):
    """Something wrong at a path, in words that follow "key: "."""

    path: Path
    message: str


class Part(BaseModel):
    """A frozen piece of a scene: its fields are the keys of its TOML table, and no others."""

    FILE: ClassVar[tuple[str, ...]] = ()
    """The key that names a file, where there may be one, and the keys that its contents fill."""

    DRAWN: ClassVar[tuple[str, ...]] = ()
    """Keys that pictures alone read: nothing that is computed depends on them."""

    CHOSEN: ClassVar[tuple[str, ...]] = ()
    """Keys whose absence leaves the choice to the program, whatever their default."""

    JUDGED: ClassVar[tuple[str, ...]] = ()
    """Keys that results are compared with: nothing that moves depends on them."""

    model_config: ClassVar[ConfigDict] = ConfigDict(
        frozen=True,
        extra="forbid",
        use_attribute_docstrings=True,
        validate_default=False,
    )

    def from_file(self) -> tuple[str, ...]:
        """Return the keys whose values came from a file; none where no file is named."""
        named = self.FILE and getattr(self, self.FILE[0]) is not None
        return self.FILE[1:] if named else ()

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong between this part's own fields; paths start at the part."""
        yield from ()


def dotted(path: Path) -> str:
    """Return a path as people write it: lines.rope.start.fixed.2."""
    return ".".join(f'"{p}"' if isinstance(p, str) and "." in p else str(p) for p in path)


def children(value: Any) -> Iterator[tuple[str | int, Any]]:
    """Yield the (key, value) pairs below a part, dict or tuple; nothing below a leaf.

    Absent optional fields (None) are left out: what a scene does not name is not there.
    """
    if isinstance(value, Part):
        own = value.__dict__
        for name in _fields(type(value)):
            child = own[name]
            if child is not None:
                yield name, child
    elif isinstance(value, dict):
        yield from value.items()
    elif isinstance(value, tuple):
        yield from enumerate(value)


@cache
def _fields(kind: type[Part]) -> tuple[str, ...]:
    """Return the names of a part's fields; pydantic takes longer, and a large sweep asks often."""
    return tuple(kind.model_fields)


def tag(kind: str) -> str:
    """Return the union tag of a kind. The marks tell tags from keys in pydantic's locations."""
    return f"<{kind}>"


class Expected(NamedTuple):
    """The words after "expected" for a value that is one of several kinds of thing."""

    words: str


def choose(
    pick: Callable[[Any], str], expected: str
) -> tuple[Discriminator, BeforeValidator, Expected]:
    """Return the annotations of a union whose kind ``pick`` reads off the raw value.

    ``pick`` raises where no kind fits. It runs before the discriminator does, because pydantic
    turns errors into reports in validators only.
    """

    def check(value: Any) -> Any:
        pick(value)
        return value

    by_kind = Discriminator(lambda value: tag(pick(value)))
    return by_kind, BeforeValidator(check), Expected(expected)


def pick_word(value: Any, key: str, words: Iterable[str], default: str | None = None) -> str:
    """Return the kind that ``key`` names in a table (or part), which must be one of ``words``.

    Raises:
        PydanticCustomError: the value is no table, or the word is missing or unknown.
    """
    words = list(words)
    known = f"{key} = " + either(f'"{word}"' for word in words)
    expected = f"expected a table with {known}"
    if isinstance(value, Part):
        return getattr(value, key)
    if not isinstance(value, dict):
        raise fault(f"{expected}, found {found(value)}")
    word = value.get(key, default)
    if word is None:
        raise fault(f"{expected}, found no {key}{did_you_mean_key(value, [key])}")
    if word not in words:
        raise fault(f"expected {known}, found {found(word)}{did_you_mean(word, words)}", key)
    return word


def either(words: Iterable[str]) -> str:
    """Return "a, b or c"."""
    *head, last = words
    return f"{', '.join(head)} or {last}" if head else last


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return '; did you mean "x"?' for the nearest known word, or nothing."""
    guess = nearest(word, known) if isinstance(word, str) else None
    return f'; did you mean "{guess}"?' if guess else ""


def unknown(name: str, known: Iterable[str]) -> str:
    """Return an unknown name as an error tells it: with the nearest known one, or all that there are."""
    known = list(known)
    others = f"; known: {', '.join(known)}" if known else "; there is none"
    return f"{found(name)}{did_you_mean(name, known) or others}"


def did_you_mean_key(table: dict[str, Any], known: Iterable[str]) -> str:
    """Return '; did you mean "x"?' for the first key of a table that resembles a known one."""
    known = list(known)
    return next((hint for key in table if (hint := did_you_mean(key, known))), "")


Name = Annotated[str, StringConstraints(strict=True, pattern=rf"^{NAME_PATTERN}$")]
"""A name given by the user: letters, digits, _ and -, starting with a letter."""


def control_character(text: str, but: str = "") -> str | None:
    """Return "U+0000" for the first character that neither tables nor files can hold, else None."""
    odd = (c for c in text if category(c) == "Cc" and c not in but)
    return next((f"U+{ord(c):04X}" for c in odd), None)


def _printable(text: str) -> str:
    if (odd := control_character(text, but="\n\t")) is not None:
        raise fault(f"expected text without control characters, found {odd}")
    return text


Text = Annotated[str, StringConstraints(strict=True), AfterValidator(_printable)]
