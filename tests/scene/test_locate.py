import json
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lumpedcable.scene.locate import LineMap

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
PRETENSION = "lines.rope.end.held.pretension"


TRICKY = '''\
# [not.a.table]
a = 1
"b.c" = { d = 2, e = [3,
  4] } # [x]
f.g = """
[h]
i = 1
"""
[j.k] # comment = 1
l = [ # ]
  [1, 2],

  "]", # 5
]
'm n' = "\\"]"
[j.o]
[[p]]
q = 1
[[p]]
q = 2
[p.r]
s = 1979-05-27 07:32:00
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("a",), 2),
        (("b.c",), 3),
        (("b.c", "d"), 3),
        (("b.c", "e", 0), 3),
        (("b.c", "e", 1), 4),
        (("f",), 5),
        (("f", "g"), 5),
        (("j",), 9),
        (("j", "k"), 9),
        (("j", "k", "l"), 10),
        (("j", "k", "l", 0, 1), 11),
        (("j", "k", "l", 1), 13),
        (("j", "k", "m n"), 15),
        (("j", "o"), 16),
        (("p", 0, "q"), 18),
        (("p", 1, "q"), 20),
        (("p", 1, "r", "s"), 22),
        (("j", "k", "absent"), 9),
        (("absent",), 1),
    ],
)
def test_keys_are_found_on_their_lines(path, line):
    assert tomllib.loads(TRICKY)  # the text is TOML
    assert LineMap(TRICKY).line(path) == line
    assert (("h",) in LineMap(TRICKY)) is False


KEYS = st.text("ab-_0", min_size=1, max_size=3) | st.text(max_size=4).map(json.dumps)
VALUES = st.recursive(
    st.integers(0, 99).map(str)
    | st.text('a"]}#=,\\', max_size=5).map(json.dumps)
    | st.just("'\"'"),
    lambda inner: (
        st.lists(inner, max_size=3).map(lambda items: "[\n" + ", # ]\n".join(items) + "\n]")
        | st.lists(inner, max_size=3).map(
            lambda items: f"{{ {', '.join(f'k{i} = {item}' for i, item in enumerate(items))} }}"
        )
    ),
    max_leaves=6,
)


@settings(max_examples=150)
@given(
    st.lists(st.tuples(st.lists(KEYS, min_size=1, max_size=3), VALUES, st.booleans()), max_size=5)
)
def test_line_map_agrees_with_the_toml_reader(entries):
    lines = []
    for keys, value, header in entries:
        dotted = ".".join(keys)
        lines.append(f"[{dotted}]\nx = {value}" if header else f"{dotted} = {value}")
    text = "\n".join(lines)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return  # a key given twice, or a surrogate: not TOML
    found = LineMap(text)

    def walk(value, path):
        if path:
            assert path in found
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, child in items:
            walk(child if isinstance(child, dict | list) else (), (*path, str(key)))

    walk(data, ())
