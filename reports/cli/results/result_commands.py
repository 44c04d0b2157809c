"""The command that prints what a result file holds, record by record, in lines, JSON and CSV."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated

import typer

from ..options import RESULT_FILE, AsCsv, AsJson, Stored
from ..terminal import Complaint, print_file, say, to_json

#: Characters with which spreadsheets let a formula begin, after white space too.
FORMULA = ("=", "+", "-", "@", "\t", "\n")


def csv_text(records: Sequence[Mapping[str, object]]) -> str:
    """Return records as CSV: a line of names, then a line for each record.

    Numbers have all digits. A missing value is an empty cell. A dictionary inside a record has a
    column for each of its entries, such as ``drifts.energy``. The items of a list are joined by
    semicolons. A text that a spreadsheet would take for a formula gets an apostrophe before it
    (https://owasp.org/www-community/attacks/CSV_Injection).
    """
    flat = [dict(_flattened(record)) for record in records]
    names = dict.fromkeys(name for record in flat for name in record)
    for name in [*names]:
        # A record with None in place of a dictionary has made a column of the dictionary's name.
        while name := name.rpartition(".")[0]:
            names.pop(name, None)
    text = io.StringIO()
    writer = csv.DictWriter(text, names, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return text.getvalue()


def _flattened(record: Mapping[str, object]) -> Iterator[tuple[str, object]]:
    """Yield a record's columns and values; the column of a nested entry is "outer.inner"."""
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from ((f"{name}.{entry}", inner) for entry, inner in _flattened(value))
        elif isinstance(value, list):
            yield name, _no_formula("; ".join(map(str, value)))
        else:
            yield name, _no_formula(value)


def _no_formula(value: object) -> object:
    """Return a value, with an apostrophe before it if it is a text that begins like a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


app = typer.Typer()


@app.command(epilog="Example: spincheck rows spincheck.sqlite --csv")
def rows(
    results: Stored = RESULT_FILE,
    verdicts: Annotated[
        bool, typer.Option("--verdicts", help="Print every verdict instead.")
    ] = False,
    tidy: Annotated[
        bool,
        typer.Option("--tidy", help="First delete results that were made again after a change."),
    ] = False,
    as_csv: AsCsv = False,
    as_json: AsJson = False,
) -> None:
    """Print every run of a result file, those of ensembles too.

    The table is cut to 80 columns; --csv and --json have every number in full.
    """
    from ....scenarios import printable
    from ..run import running
    from ..run.summary import run_lines, run_records, verdict_lines, verdict_records

    if as_csv and as_json:
        raise Complaint("takes '--csv' or '--json', not both")
    if tidy:
        say(running.tidied(results))
    found = running.read(results)
    if as_csv or as_json:
        records = verdict_records(found) if verdicts else run_records(found)
        print_file(csv_text(records)) if as_csv else print(to_json(records))
        return
    for line in verdict_lines(found.verdicts) if verdicts else run_lines(found.every_row):
        print(printable(line))
