"""The page and the JSON Schema of the scene file are those of the format, whole."""

import json
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from spincheck.reports.harness.scene_checks.published import published_values
from spincheck.scenarios import EFFECTS, loads
from spincheck.scenarios.document import Document, SomeComponents
from spincheck.scenarios.format_page import EXAMPLES, format_page
from spincheck.scenarios.schema import SCHEMA_FILE, schema_text

PAGE = Path(__file__).parents[2] / "docs/reference/scene-format.md"
FIRST = PAGE.parents[1] / "start/first-scene.md"

#: All examples of the page in one file.
#: A body has a pivot or a table, not both.
EXAMPLE = "\n".join(
    text for name, (_, text) in EXAMPLES.items() if text and name != "[effects.table]"
)


def _tables(annotation: Any) -> set[type[BaseModel]]:
    """The models that a field's type is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        inner = [_tables(field.annotation) for field in annotation.model_fields.values()]
        return {annotation}.union(*inner)
    return set().union(*(_tables(one) for one in getattr(annotation, "__args__", ())))


def test_the_page_is_in_step_with_the_format() -> None:
    """If this fails: make format-page."""
    assert PAGE.read_text(encoding="utf-8") == format_page()


def test_every_table_of_the_format_is_there() -> None:
    # A value within a table, in the place of a vector.
    inline = {SomeComponents}
    assert {model for model, _ in EXAMPLES.values()} == _tables(Document) - inline


def test_every_key_says_what_it_means() -> None:
    for model in _tables(Document):
        for key, field in model.model_fields.items():
            assert field.description, f"{model.__name__}.{key}"


def test_every_key_of_an_effect_has_a_unit() -> None:
    for effect in EFFECTS.values():
        keys = set() if effect.is_part else set(effect.model.model_fields)
        assert set(effect.model.UNITS) == keys, effect.name


def test_its_examples_make_a_scene_whose_published_value_holds() -> None:
    scenario = loads(EXAMPLE, "example")
    # A body has a pivot or a table, and a torque constant in one of two frames.
    assert scenario.called_for == EFFECTS.keys() - {"table", "torque_world"}
    assert [value.holds for value in published_values(scenario)] == [True]


def test_a_published_value_that_is_off_would_not_hold() -> None:
    text = EXAMPLE.replace("energy = 4.5064", "energy = 4.5164")
    assert [value.holds for value in published_values(loads(text, "example"))] == [False]


def test_the_first_scene_of_a_newcomer_is_right() -> None:
    (block,) = re.findall(r"```toml\n(.*?)```", FIRST.read_text(encoding="utf-8"), re.DOTALL)
    assert loads(block, "my-top").constraint.is_pivot


def test_the_schema_is_in_step_with_the_format():
    """If this fails: python -m spincheck.scenarios.schema."""
    assert SCHEMA_FILE.read_text(encoding="utf-8") == schema_text()


def test_the_schema_closes_every_table_to_unknown_keys():
    schema = json.loads(schema_text())
    tables = [schema, *schema["$defs"].values()]
    assert all(table["additionalProperties"] is False for table in tables)


def test_the_schema_asks_for_what_the_format_asks_for():
    needed = {name for name, field in Document.model_fields.items() if field.is_required()}
    assert set(json.loads(schema_text())["required"]) == needed
