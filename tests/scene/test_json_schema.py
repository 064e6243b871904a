import json
import tomllib
from pathlib import Path

import good_scenes
import jsonschema
import pytest

from lumpedcable.scene import (
    json_schema,
)

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
PRETENSION = "lines.rope.end.held.pretension"


def without_nan(value):
    return json.loads(json.dumps(value).replace("NaN", "0.0"))


@pytest.mark.parametrize(
    "text",
    [
        *(path.read_text() for path in sorted(CONFIGS.glob("*.toml"))),
        good_scenes.ROPE,
        good_scenes.BRIDLE,
    ],
)
def test_scenes_that_load_fit_the_json_schema(text):
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(without_nan(tomllib.loads(text)))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("lines", "rope", "length"), "long"),
        (("lines", "rope", "length"), "60"),
        (("lines", "rope", "length"), -60),
        (("lines", "rope", "segments"), 2.5),
        (("lines", "rope", "lenght"), 60),
        (("lines", "rope", "end"), {"fix": [0, 0, 0]}),
        (("lines", "rope", "start"), {"fixed": [0, 0]}),
        (("materials", "nylon", "law"), "tahn"),
        (("solver", "method"), "rk5"),
        (("output", "duration"), None),
        (("solver", "courant"), 1.5),
    ],
)
def test_scenes_that_do_not_load_do_not_fit_the_json_schema(path, value):
    data = without_nan(tomllib.loads(good_scenes.ROPE))
    *parents, key = path
    table = data
    for parent in parents:
        table = table[parent]
    if value is None:
        del table[key]
    else:
        table[key] = value
    validator = jsonschema.Draft202012Validator(json_schema())
    assert len(list(validator.iter_errors(data))) == 1


def test_the_json_schema_states_the_unit_of_every_quantity():
    line = json_schema()["$defs"]["Line"]["properties"]
    assert "kg/m" in json.dumps(line["mass"])
    assert {kind["type"] for kind in line["mass"]["anyOf"]} == {"number", "string"}
