"""The JSON Schema that editors read is that of the model."""

import json

from spincheck.scenarios.document import Document
from spincheck.scenarios.schema import SCHEMA_FILE, schema_text


def test_the_file_is_in_step_with_the_model():
    """If this fails: python -m spincheck.scenarios.schema."""
    assert SCHEMA_FILE.read_text(encoding="utf-8") == schema_text()


def test_it_closes_every_table_to_unknown_keys():
    schema = json.loads(schema_text())
    tables = [schema, *schema["$defs"].values()]
    assert all(table["additionalProperties"] is False for table in tables)


def test_it_asks_for_what_the_model_asks_for():
    needed = {name for name, field in Document.model_fields.items() if field.is_required()}
    assert set(json.loads(schema_text())["required"]) == needed


def test_every_key_with_a_unit_says_it():
    """A number without a description leaves its unit to be guessed."""
    schema = json.loads(schema_text())
    for table in ("BodyTable", "StartTable", "GravityTable", "DragTable", "TorqueTable", "Window"):
        for key, value in schema["$defs"][table]["properties"].items():
            assert value.get("description"), f"{table}.{key}"
