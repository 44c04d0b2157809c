"""The line of a TOML file on which a key stands."""

import pytest
from spincheck.scenarios.locate import line_of

TEXT = '''spincheck = 1
description = """
[body]
mass = 7
"""
  [ body ]
mass = 2.0
inertia = [
    1.0,
    2.0,
]
[effects.gravity]
acceleration = [0, 0, -9.81]
[[published]]
t = 1
[[published]]
t = 2
[window] # a comment
duration = 1.0
'''


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (("spincheck",), 1),
        (("body",), 6),
        (("body", "mass"), 7),
        (("body", "inertia"), 8),
        (("body", "inertia", 1), 8),
        (("body", "colour"), 6),
        (("effects", "gravity", "acceleration", 2), 13),
        (("published", 0, "t"), 15),
        (("published", 1, "t"), 17),
        (("published", 1), 16),
        (("window", "duration"), 19),
        (("nothing",), None),
        ((), None),
    ],
    ids=str,
)
def test_a_key_stands_on_its_line(keys, line):
    assert line_of(TEXT, keys) == line


def test_dotted_keys_are_found():
    assert line_of("a = 1\neffects.drag.rotational = 2\n", ("effects", "drag", "rotational")) == 2


def test_tables_in_one_line_are_found_by_their_name():
    assert line_of("a = 1\neffects = { drag = { rotational = -2 } }\n", ("effects", "drag")) == 2
