"""Fills the tables of scene-language.md and fitting.md from the models: python docs/reference.py.

A table stands between `<!-- keys of CLASS -->` and `<!-- end -->`; of a class with shared keys,
`<!-- own keys of CLASS -->` takes those alone that it adds.
"""

import json
import re
import types
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from lumpedcable.fitting import language
from lumpedcable.scene import (
    bodies,
    carried,
    ends,
    environment,
    events,
    lines,
    materials,
    measures,
    motions,
    moved,
    run,
    scene,
    targets,
)
from lumpedcable.scene.part import Expected, Part, either
from lumpedcable.scene.quantities import Count, Quantity
from lumpedcable.scene.tree import fields

PAGE = Path(__file__).with_name("scene-language.md")
PAGES = (PAGE, Path(__file__).with_name("fitting.md"))
MODULES = (
    bodies,
    carried,
    environment,
    events,
    ends,
    lines,
    materials,
    measures,
    motions,
    moved,
    run,
    scene,
    targets,
    language,
)
HEAD = "| key | value | default | meaning |\n|---|---|---|---|\n"
BLOCK = re.compile(r"(<!-- (own )?keys of (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def kind(annotation: Any) -> str:
    """What a key holds, in words: "positive length (m)"."""
    if annotation is Any:
        return "number with or without a unit"
    notes: tuple[Any, ...] = ()
    while get_origin(annotation) is Annotated:
        annotation, *more = get_args(annotation)
        notes += tuple(more)
    told = next((n for n in notes if isinstance(n, Quantity | Count | Expected)), None)
    if isinstance(told, Expected):
        return told.words
    if told is not None:
        return re.sub(r"^an? ", "", told.expected)
    arguments = [a for a in get_args(annotation) if a is not type(None)]
    origin = get_origin(annotation)
    if origin in (Union, types.UnionType):
        return kind(arguments[0])
    if origin is Literal:
        return either(f'`"{word}"`' for word in arguments)
    if origin is tuple:
        each = kind(arguments[0])
        return (
            f"list, each {each}"
            if Ellipsis in arguments
            else f"list of {len(arguments)}, each {each}"
        )
    if origin is dict:
        if arguments[0] is not arguments[1] and arguments[1] in (Any, language.Free):
            return "tables by key" if arguments[1] is language.Free else "values by key"
        return "tables by name" if _is_part(arguments[1]) else f"by name: {kind(arguments[1])}"
    return "table" if _is_part(annotation) else {bool: "true or false", str: "text"}[annotation]


def _is_part(annotation: Any) -> bool:
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        return all(map(_is_part, get_args(annotation)))
    return isinstance(annotation, type) and issubclass(annotation, Part)


def default(field: Any) -> str:
    """What a key is where it is not given."""
    if field.is_required():
        return "needed"
    if isinstance(extra := field.json_schema_extra, dict) and extra.get("minProperties"):
        return "needed, one at least"
    value = field.get_default(call_default_factory=True)
    if value is None or value in ((), {}):
        return "absent"
    if isinstance(value, Part):
        return "its defaults"
    if isinstance(value, tuple):
        return "all"
    return f"`{json.dumps(value)}`"


def table(cls: type[Part], own: bool = False) -> str:
    """The rows of a class, one per key."""
    shared = fields(cls.__mro__[1]) if own else {}
    rows = [
        (f"`{key}`", kind(annotation), default(cls.model_fields[key]),
         " ".join((cls.model_fields[key].description or "").replace("``", "`").split()))
        for key, annotation in fields(cls).items()
        if key not in shared
    ]  # fmt: skip
    cells = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return HEAD + "".join(f"| {' | '.join(row)} |\n" for row in cells)


def filled(page: str) -> str:
    """The page with every table as the models are now."""

    def block(found: re.Match[str]) -> str:
        start, own, name, end = found.groups()
        cls = next(vars(module)[name] for module in MODULES if name in vars(module))
        return start + table(cls, bool(own)) + end

    return BLOCK.sub(block, page)


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page.read_text()))
