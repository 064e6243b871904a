"""The scene language as a JSON schema, for editors and other programs."""

from __future__ import annotations

from typing import Any

from lumpedcable.scene.scene import Scene


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a scene file.

    Every quantity accepts a number in SI or a text with a unit, and says which unit. What holds
    between keys (a name that exists, a tension within reach) is for the loader to check.
    """
    schema = _without_null(Scene.model_json_schema())
    schema["properties"]["sweep"] = {
        "type": "object",
        "description": (
            "Values for numbers of the scene by full path: a list, or a range with from, to and "
            "count or step; and tables of several keys: cases, zip, sample. Every combination is a "
            "run, the first key changing slowest."
        ),
        "additionalProperties": {"anyOf": [{"type": "array", "minItems": 1}, {"type": "object"}]},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "lumpedcable scene",
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _without_null(schema: Any) -> Any:
    """Return a schema without the null of optional keys: TOML has none, they are left out."""
    if isinstance(schema, list):
        return [_without_null(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    clean = {k: _without_null(v) for k, v in schema.items() if not (k == "default" and v is None)}
    kinds = clean.get("anyOf")
    if isinstance(kinds, list) and {"type": "null"} in kinds:
        kinds = [kind for kind in kinds if kind != {"type": "null"}]
        del clean["anyOf"]
        # The key's own description is closer to it than that of its type.
        return {**kinds[0], **clean} if len(kinds) == 1 else {**clean, "anyOf": kinds}
    return clean
