"""Scenario files with one thing wrong each, made from the format's own schema.

Whatever key the format has or will have is found in the schema, and so is a value it takes; a
file in which that key stands is looked for by leaving out or adding keys beside it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations
from typing import Any

from spincheck.scenarios import Document, ScenarioError, loads

#: Keys lead to a place in a file as they do in what a TOML parser returns.
Keys = tuple[int | str, ...]
Tables = dict[str, Any]

SCHEMA = Document.model_json_schema()
#: The required keys and no others: whatever else a file may hold is added to this.
LEAST: Tables = {
    "spincheck": 1,
    "title": "t",
    "source": "s",
    "body": {"mass": 2.0, "inertia": [1.0, 2.0, 2.5], "com": [0.1, 0.2, 0.3]},
    "start": {"euler_zyz_deg": [10.0, 30.0, 20.0], "omega_body": [0.5, 1.0, -2.0]},
    "window": {"duration": 1.0, "samples": 5},
}


class Raw(str):
    """A value as it is to stand in the file."""


@dataclass(frozen=True, eq=False)
class Leaf:
    """A key that holds no table.

    Attributes
    ----------
    keys : where it stands
    schema : what the JSON Schema says of its value
    """

    keys: Keys
    schema: dict[str, Any]

    @property
    def name(self) -> str:
        """As a test is named after it."""
        return ".".join(str(key) for key in self.keys if isinstance(key, str))

    @property
    def numbers(self) -> bool:
        """Whether its value is a number or made of numbers."""
        return self.name != "spincheck" and all(
            isinstance(entry, float | int) for entry in _flat(self.example)
        )

    @property
    def example(self) -> Any:
        """A value that the format takes."""
        return value_at(self.file, self.keys)

    @property
    def file(self) -> Tables:
        """A valid file in which it stands."""
        return _file_with(self.keys)


@cache
def leaves() -> tuple[Leaf, ...]:
    """Every key of the format that holds no table."""
    return tuple(_leaves(SCHEMA, ()))


def _leaves(schema: dict[str, Any], keys: Keys) -> Iterator[Leaf]:
    for name, held in schema["properties"].items():
        arms = [arm for arm in _arms(held) if arm.get("type") != "null"]
        if "properties" in arms[0]:
            yield from _leaves(arms[0], (*keys, name))
        elif "properties" in _resolved(arms[0].get("items", {})):
            yield from _leaves(_resolved(arms[0]["items"]), (*keys, name, 0))
        else:
            yield Leaf((*keys, name), held)


@cache
def tables() -> tuple[Keys, ...]:
    """Every table of the format, the file itself left out."""
    return tuple(_tables(SCHEMA, ()))


def _tables(schema: dict[str, Any], keys: Keys) -> Iterator[Keys]:
    for name, held in schema["properties"].items():
        arm = next(arm for arm in _arms(held) if arm.get("type") != "null")
        item = _resolved(arm.get("items", {}))
        inner, place = (item, (*keys, name, 0)) if "properties" in item else (arm, (*keys, name))
        if "properties" in inner:
            yield place
            yield from _tables(inner, place)


def _resolved(schema: dict[str, Any]) -> dict[str, Any]:
    if "$ref" in schema:
        definition: dict[str, Any] = SCHEMA["$defs"][schema["$ref"].rsplit("/", 1)[1]]
        return definition
    return schema


def _arms(schema: dict[str, Any]) -> list[dict[str, Any]]:
    """What a value may be, one by one."""
    resolved = _resolved(schema)
    arms = resolved.get("anyOf") or resolved.get("oneOf")
    return list(chain.from_iterable(_arms(arm) for arm in arms)) if arms else [resolved]


def _examples(schema: dict[str, Any], row: int = 0) -> Iterator[Any]:
    """Values that a schema allows; what else is asked of them decides between them."""
    for arm in _arms(schema):
        kind = arm.get("type")
        if "const" in arm or "enum" in arm:
            yield arm.get("const", arm.get("enum", [None])[0])
        elif "properties" in arm:
            yield {key: next(_examples(arm["properties"][key])) for key in arm.get("required", ())}
        elif kind == "array" and "prefixItems" in arm:
            if all(_resolved(item).get("type") == "number" for item in arm["prefixItems"]):
                n = len(arm["prefixItems"])
                positive = ["exclusiveMinimum" in _resolved(item) for item in arm["prefixItems"]]
                yield [1.0] * n if all(positive) else [float(k == row) for k in range(n)]
                yield [1.0] + [float(k == row) for k in range(n - 1)]
            else:
                yield [next(_examples(item, k)) for k, item in enumerate(arm["prefixItems"])]
        elif kind == "array":
            count = max(arm.get("minItems", 1), 1)
            for rows in zip(*(_examples(arm["items"], k) for k in range(count)), strict=True):
                yield list(rows)
        elif kind in ("number", "integer"):
            yield max(1.0, arm.get("minimum", 0)) if kind == "number" else arm.get("minimum", 1)
        elif kind == "string":
            yield "x"


#: By table, what its keys need besides: the file that a body's numbers are from, all of a table
#: that a body stands on, and its weight.
ALONG: dict[Keys, dict[Keys, Any]] = {
    ("body",): {
        ("body", "model"): "robot.urdf",
        ("body", "link"): "top",
        ("body", "sha256"): "0" * 64,
    },
    ("effects", "table"): {
        ("effects", "table", "height"): 0.0,
        ("effects", "table", "tip"): [0.0, 0.0, 0.0],
        ("effects", "table", "radius"): 0.0,
        ("effects", "gravity", "acceleration"): [0.0, 0.0, -9.81],
    },
}


@cache
def _file_with(keys: Keys) -> Tables:
    """A valid file in which a key or a table stands, found by trying what stands beside it."""
    if holds(LEAST, keys):
        return LEAST
    for example in _examples(_schema_at(keys)):
        begun = changed(_with_tables_of(keys), keys, example)
        for file in chain(_with_less(begun, keys), _with_more(begun, keys)):
            if is_scene(file):
                return file
    raise AssertionError(f"no valid file was found in which {keys} stands: help `_examples`")


def _with_tables_of(keys: Keys) -> Tables:
    """The least file, with the tables that lead to a key, and in them what they need."""
    file = LEAST
    for length in range(1, len(keys)):
        schema = _schema_at(keys[:length])
        if not holds(file, keys[:length]) and "properties" in _arms(schema)[0]:
            file = changed(file, keys[:length], next(_examples(schema)))
    return file


def _schema_at(keys: Keys) -> dict[str, Any]:
    schema = SCHEMA
    for key in keys:
        arm = next(arm for arm in _arms(schema) if arm.get("type") != "null")
        schema = arm["properties"][key] if isinstance(key, str) else arm["items"]
    return schema


def _with_less(file: Tables, keys: Keys) -> Iterator[Tables]:
    """The file without some of the keys in the same table."""
    beside = [key for key in value_at(file, keys[:-1]) if key != keys[-1]] if keys[:-1] else []
    for count in range(len(beside) + 1):
        for dropped in combinations(beside, count):
            less = file
            for key in dropped:
                less = without(less, (*keys[:-1], key))
            yield less


def _with_more(file: Tables, keys: Keys) -> Iterator[Tables]:
    """The file with another key in the same table, or the next one; or with several that go along.

    No schema tells that a key needs others (`ALONG`).
    """
    inside = "properties" in _arms(_schema_at(keys))[0]
    table = keys if inside else keys[:-1]
    properties = next(arm for arm in _arms(_schema_at(table)) if "properties" in arm)["properties"]
    for key, schema in properties.items():
        if not holds(file, (*table, key)):
            for example in _examples(schema):
                yield changed(file, (*table, key), example)
    whole = file
    for place, value in ALONG.get(table, {}).items():
        whole = changed(whole, place, value)
    yield whole


def is_scene(file: Tables) -> bool:
    """Whether the loader takes it."""
    try:
        loads(written(file), name="made")
    except ScenarioError:
        return False
    return True


def holds(file: Tables, keys: Keys) -> bool:
    """Whether a key stands in a file."""
    try:
        value_at(file, keys)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def value_at(file: Any, keys: Keys) -> Any:
    """What stands there."""
    for key in keys:
        file = file[key]
    return file


def changed(file: Any, keys: Keys, value: Any) -> Any:
    """The file with another value there; tables that are not there are made."""
    if not keys:
        return value
    key, *rest = keys
    if isinstance(key, int):
        return [changed(file[key] if file else {}, tuple(rest), value), *file[key + 1 :]]
    inner = file.get(key, [] if rest and isinstance(rest[0], int) else {})
    return {**file, key: changed(inner, tuple(rest), value)}


def without(file: Any, keys: Keys) -> Any:
    """The file without what stands there."""
    key, *rest = keys
    if not rest:
        return {k: v for k, v in file.items() if k != key}
    if isinstance(key, int):
        return [without(file[key], tuple(rest)), *file[key + 1 :]]
    return {**file, key: without(file[key], tuple(rest))}


def written(file: Tables) -> str:
    """As TOML."""
    return "".join(f"{line}\n" for line, _ in _lines(file, ()))


def line_of(file: Tables, keys: Keys) -> int:
    """The line, from 1 on, on which a key or a table stands in what `written` returns."""
    places = [place for _, place in _lines(file, ())]
    return places.index(keys) + 1


def _lines(table: Tables, keys: Keys) -> Iterator[tuple[str, Keys]]:
    for key, value in table.items():
        if not _is_table(value):
            yield f"{key} = {in_toml(value)}", (*keys, key)
    for key, value in table.items():
        if _is_table(value):
            rows = value if isinstance(value, list) else [value]
            brackets = ("[[", "]]") if isinstance(value, list) else ("[", "]")
            for index, row in enumerate(rows):
                place = (*keys, key, index) if isinstance(value, list) else (*keys, key)
                name = ".".join(part for part in place if isinstance(part, str))
                yield f"{brackets[0]}{name}{brackets[1]}", place
                yield from _lines(row, place)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


def in_toml(value: Any) -> str:
    """A value as it stands in a file."""
    if isinstance(value, Raw):
        return value
    if isinstance(value, list):
        return f"[{', '.join(in_toml(entry) for entry in value)}]"
    return f'"{value}"' if isinstance(value, str) else str(value)


def _flat(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for entry in value:
            yield from _flat(entry)
    else:
        yield value


def with_entries(value: Any, entry: Any) -> Iterator[tuple[Keys, Any]]:
    """A value with each of its entries replaced in turn, and all of them; itself if it has none."""
    if not isinstance(value, list):
        yield (), entry
        return
    for index, held in enumerate(value):
        for inner, replaced in with_entries(held, entry):
            yield (index, *inner), [*value[:index], replaced, *value[index + 1 :]]
