"""Rows and verdicts as CSV, with the names that they have in JSON."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence

#: What a formula begins with, or white space that spreadsheets pass over before one.
FORMULA = ("=", "+", "-", "@", "\t", "\n")


def csv_text(records: Sequence[Mapping[str, object]]) -> str:
    """One line a record under one line of names; numbers read back to the last bit.

    A missing value is an empty cell. A table inside a record has a column for each of its entries,
    as in ``drifts.energy``; a list is joined by semicolons. A text that a spreadsheet would take
    for a formula begins with an apostrophe
    (https://owasp.org/www-community/attacks/CSV_Injection).
    """
    flat = [dict(_flattened(record)) for record in records]
    names = list(dict.fromkeys(name for record in flat for name in record))
    text = io.StringIO()
    writer = csv.DictWriter(text, names, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return text.getvalue()


def _flattened(record: Mapping[str, object]) -> Iterator[tuple[str, object]]:
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from ((f"{name}.{entry}", inner) for entry, inner in _flattened(value))
        elif isinstance(value, list):
            yield name, _no_formula("; ".join(map(str, value)))
        else:
            yield name, _no_formula(value)


def _no_formula(value: object) -> object:
    """The value, a text with an apostrophe before it where it begins like a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value
