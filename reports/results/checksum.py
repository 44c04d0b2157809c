"""A checksum for each record of a result file, which detects accidental changes.

It is no signature: whoever forges a record can compute its checksum.
"""

import json
import math
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

#: The name of its column, in every table.
CHECKSUM = "checksum"


def checksum(table: str, record: Mapping[str, Any]) -> str:
    """SHA-256 of a record's texts and numbers as SQLite returns them, in hexadecimal.

    Motions are left out: they may be dropped later, and their archives have checksums of their own
    (CRC-32, as every zip file).
    """
    content = {
        name: _as_stored(value)
        for name, value in record.items()
        if name != CHECKSUM and value is not None and not isinstance(value, bytes)
    }
    # What SQLite keeps as NULL.
    content = {name: value for name, value in content.items() if value is not None}
    return sha256(json.dumps([table, content], sort_keys=True).encode()).hexdigest()


def _as_stored(value: Any) -> str | float | None:
    """A value as it comes back: SQLite has no bool, no NaN and no −0, and may keep 1.0 as 1."""
    if isinstance(value, str):
        return value
    number = float(value) + 0.0
    return None if math.isnan(number) else number
