"""Every key missing, misspelt, doubled, of another type, not a number: one complaint each.

The keys come from the format's own schema (`mutated_scenes`), so that a new one is tested at once.
"""

import re
from functools import cache

import pytest
from case_loops import each_case
from mutated_scenes import (
    LEAST,
    Leaf,
    Raw,
    changed,
    holds,
    is_scene,
    leaves,
    line_of,
    tables,
    value_at,
    with_entries,
    without,
    written,
)
from spincheck.scenarios import ScenarioError, loads

pytestmark = pytest.mark.slow

NAME = "made"
#: No key takes any of these.
NEVER = {
    "a date": "1979-05-27",
    "a time": "07:32:00",
    "a moment": "1979-05-27T07:32:00Z",
    "a table": "{ a = 1 }",
    "nan": "nan",
    "+inf": "inf",
    "-inf": "-inf",
    "overflowing": "1e400",
    "an array in an array in an array": "[[[1.0]]]",
    "an integer beyond doubles": "1" + "0" * 400,
    "an integer beyond Python": "1" + "0" * 5000,
    "one that only TOML reads": "0x" + "f" * 5000,
}
NOT_A_NUMBER = {"text": '"1"', "true": "true", "an empty array": "[]"}
NOT_A_TEXT = {"a number": "1", "true": "true", "empty": '""', "blank": '" "'}
#: An escape, a line feed, a line separator: a terminal would act on them.
CONTROL = {"escape": r"\u001b[31m", "second line": r"a\nb", "delete": r"\u007f", "NUL": r"\u0000"}

LEAVES = {leaf.name: leaf for leaf in leaves()}
NUMBERS = {name: leaf for name, leaf in LEAVES.items() if leaf.numbers}
ARRAYS = {name: leaf for name, leaf in NUMBERS.items() if isinstance(leaf.example, list)}
TEXTS = {name: leaf for name, leaf in LEAVES.items() if isinstance(leaf.example, str)}


@cache
def complaint_about(text: str) -> str:
    """The loader's complaint about a text: one line without control characters."""
    with pytest.raises(ScenarioError) as raised:
        loads(text, NAME)
    message = str(raised.value)
    assert message.isprintable(), message
    return message


def assert_reported(file, leaf: Leaf) -> None:
    """The complaint names the line and the key; or the line where it is not TOML at all."""
    place = f"{NAME}:{line_of(file, leaf.keys)}: "
    message = complaint_about(written(file))
    assert message.startswith(place)
    assert leaf.keys[-1] in message or "not valid TOML" in message


def each(values: dict[str, str], kept: dict[str, Leaf]):
    """A test for each value in each key."""
    return each_case(
        ("leaf", "value"), [(leaf, value) for leaf in kept.values() for value in values.values()]
    )


@each(NEVER, LEAVES)
def test_a_value_of_no_use_anywhere_is_refused_in_its_line(leaf, value):
    assert_reported(changed(leaf.file, leaf.keys, Raw(value)), leaf)


@each(NEVER | NOT_A_NUMBER, NUMBERS)
def test_no_number_among_others_may_be_anything_else(leaf, value):
    for _, entries in with_entries(leaf.example, Raw(value)):
        assert_reported(changed(leaf.file, leaf.keys, entries), leaf)


@each(NOT_A_TEXT, TEXTS)
def test_a_text_says_something(leaf, value):
    file = changed(leaf.file, leaf.keys, Raw(value))
    if leaf.name == "description" and value.startswith('"'):
        assert is_scene(file)
    else:
        assert_reported(file, leaf)


@each(CONTROL, TEXTS)
def test_a_text_cannot_command_a_terminal(leaf, value):
    file = changed(leaf.file, leaf.keys, Raw(f'"{value}"'))
    if leaf.name == "description" and value == CONTROL["second line"]:
        assert is_scene(file)
    else:
        assert_reported(file, leaf)


@each_case("leaf", LEAVES)
def test_a_missing_key_is_named_unless_it_may_be_left_out(leaf):
    file = without(leaf.file, leaf.keys)
    if not is_scene(file):
        table = leaf.keys[:-1]
        message = complaint_about(written(file))
        assert leaf.keys[-1] in message
        at_table = f"{NAME}:{line_of(file, table)}: " if table else f"{NAME}: "
        assert message.startswith(at_table)


@each_case("keys", tables())
def test_a_missing_table_is_named_unless_it_may_be_left_out(keys):
    file = without(LEAST, keys) if holds(LEAST, keys) else LEAST
    if not is_scene(file):
        assert complaint_about(written(file)) == f"{NAME}: [{keys[0]}]: is missing"


@each_case("leaf", LEAVES)
def test_a_misspelt_key_is_reported_beside_the_known_ones(leaf):
    misspelt = f"{leaf.keys[-1]}{leaf.keys[-1][-1]}"
    file = changed(leaf.file, (*leaf.keys[:-1], misspelt), leaf.example)
    message = complaint_about(written(file))
    assert message.startswith(f"{NAME}:{line_of(file, (*leaf.keys[:-1], misspelt))}: ")
    assert f"{misspelt}: unknown key; did you mean '{leaf.keys[-1]}'? known keys: " in message


@each_case("leaf", LEAVES)
def test_a_key_given_twice_is_reported_in_its_second_line(leaf):
    lines = written(leaf.file).splitlines()
    line = line_of(leaf.file, leaf.keys)
    message = complaint_about("\n".join([*lines[:line], lines[line - 1], *lines[line:]]))
    assert re.match(rf"{NAME}:{line + 1}: not valid TOML: Cannot overwrite a value", message)


@each_case("keys", [keys for keys in tables() if all(isinstance(key, str) for key in keys)])
def test_a_table_given_twice_is_reported(keys):
    head = f"[{'.'.join(keys)}]"
    file = changed(LEAST, keys, {}) if not holds(LEAST, keys) else LEAST
    message = complaint_about(f"{written(file)}{head}\n")
    assert "not valid TOML: Cannot declare" in message


@each_case("keys", tables())
@each_case("value", ["true", "1", '"x"', "nan", "1979-05-27", "[1]"])
def test_what_is_no_table_is_refused_where_a_table_belongs(keys, value):
    place = tuple(key for key in keys if isinstance(key, str))
    message = complaint_about(written(changed(_without_table(place), place, Raw(value))))
    assert re.match(rf"{NAME}:\d+: ", message)
    assert place[-1] in message


def _without_table(place):
    return without(LEAST, place) if holds(LEAST, place) else LEAST


@each_case("leaf", ARRAYS)
def test_an_array_of_another_length_is_reported_once(leaf):
    for entries in ([], leaf.example[:-1], [*leaf.example, leaf.example[0]]):
        file = changed(leaf.file, leaf.keys, entries)
        if not is_scene(file):  # a particle more is a body still
            assert_reported(file, leaf)


def test_every_way_of_giving_an_attitude_excludes_the_others():
    ways = ("euler_zyz_deg", "quaternion_wxyz", "rotation_vector_deg")
    values = {way: LEAVES[f"start.{way}"].example for way in ways}
    for first in ways:
        for second in set(ways) - {first}:
            start = {first: values[first], second: values[second], "omega_body": [0.0, 0.0, 1.0]}
            message = complaint_about(written({**LEAST, "start": start}))
            assert re.search(r":\d+: \[start\]: attitude takes exactly one of .* got '", message)


#: Beside those of `scenarios/test_document.py`.
@each_case(
    ("keys", "value", "rule"),
    {
        "indefinite": (
            ("body", "inertia"),
            [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "must be positive",
        ),
        "norm 1.4": (("start", "quaternion_wxyz"), [1.0, 1.0, 0.0, 0.0], "norm 1, got norm 1.41"),
        "published norm 2": (
            ("published", 0, "quaternion_wxyz"),
            [0.0, 2.0, 0.0, 0.0],
            "must have norm 1",
        ),
        "step beyond the window": (("expect", 0, "timestep"), 1.1, "must not exceed the window"),
    }.values(),
)
def test_values_that_do_not_go_together_are_reported_at_the_key_to_blame(keys, value, rule):
    (leaf,) = [leaf for leaf in LEAVES.values() if leaf.keys == keys]
    file = changed(leaf.file, keys, value)
    assert_reported(file, leaf)
    assert rule in complaint_about(written(file))


def test_a_planted_hole_in_the_format_is_found():
    """The teeth: a number that may be infinite passes the loader, and so fails these tests."""
    leaf = LEAVES["body.mass"]
    file = changed(leaf.file, leaf.keys, 3.0)
    with pytest.raises(pytest.fail.Exception):
        assert_reported(file, leaf)
    assert value_at(file, leaf.keys) == 3.0
