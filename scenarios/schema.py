"""The format's JSON Schema, for completion and checks in editors."""

import json
from pathlib import Path

from .document import Document
from .regular_files import write_new

SCHEMA_FILE = Path(__file__).with_name("schema.json")


def schema_text() -> str:
    """Return the JSON Schema of scene files, as the text of `schema.json`."""
    return json.dumps(Document.model_json_schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    write_new(SCHEMA_FILE, schema_text())
