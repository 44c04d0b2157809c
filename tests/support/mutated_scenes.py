"""Scenario files with one thing wrong each, made from the format's own schema.

Whatever key the format has or will have is found in the schema; a file in which it stands, in the
library or among `SPECIAL`.
"""

import json
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain
from typing import Any

from spincheck.scenarios import LIBRARY, Document, ScenarioError, loads
from spincheck.scenarios.signals import SIGNAL

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
        return next(file for file in _files() if holds(file, self.keys))


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


#: Files of keys that the library has not, or only beside others of which one is needed.
MODEL = {"model": "robot.urdf", "link": "top", "sha256": "0" * 64, "welded": ["a"]}
SPECIAL: list[Tables] = [
    {**LEAST, "body": LEAST["body"] | MODEL},
    *(
        {**LEAST, "published": [{"t": 0.5, "tolerance": 0.1, "source": "s", name: value}]}
        for name, value in {
            "omega_body": [1.0, 2.0, 3.0],
            "omega_world": [1.0, 2.0, 3.0],
            "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0],
            "com_world": [1.0, 2.0, 3.0],
            "L_world": [1.0, 2.0, 3.0],
            "energy": 1.0,
        }.items()
    ),
    *(
        {**LEAST, "expect": [{"engine": "e", "method": "m", "timestep": 0.1, name: value}]}
        for name, value in {**dict.fromkeys(SIGNAL, 0.1), "outcome": "diverges"}.items()
    ),
]


@cache
def _files() -> list[Tables]:
    """Valid files, of which each key of the format stands in one: the smallest first."""
    texts = sorted((path.read_text("utf-8") for path in LIBRARY.rglob("*.toml")), key=len)
    return [LEAST, *SPECIAL, *map(tomllib.loads, texts)]


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
    return json.dumps(value, ensure_ascii=False)


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
