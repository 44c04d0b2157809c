"""The commands that print what a result file holds, record by record."""

from collections.abc import Iterable
from typing import Any

import typer

from ..options import RESULT_FILE, AsCsv, AsJson, Stored
from ..terminal import BAD_INPUT, Complaint, as_complaint, to_json

app = typer.Typer()
MEGABYTE = 1e6


@app.command(epilog="Example: spincheck rows spincheck.sqlite --csv")
def rows(results: Stored = RESULT_FILE, as_csv: AsCsv = False, as_json: AsJson = False) -> None:
    """Print every run of a result file.

    The table is cut to 80 columns; --csv and --json have every number in full.
    """
    from ..run import running
    from ..run.brief_records import run_lines
    from ..run.summary import row_record

    stored = running.read(results).rows
    if as_csv or as_json:
        _print_records([row_record(row) for row in stored], as_csv, as_json)
    else:
        _print_lines(run_lines(stored))


@app.command(epilog="Example: spincheck verdicts spincheck.sqlite --json")
def verdicts(results: Stored = RESULT_FILE, as_csv: AsCsv = False, as_json: AsJson = False) -> None:
    """Print every verdict of a result file.

    The table is cut to 80 columns; --csv and --json have every number in full.
    """
    from ..run import running
    from ..run.brief_records import verdict_lines
    from ..run.summary import verdict_records

    stored = running.read(results)
    if as_csv or as_json:
        _print_records(verdict_records(stored), as_csv, as_json)
    else:
        _print_lines(verdict_lines(stored.verdicts))


@app.command(epilog="Example: spincheck points spincheck.sqlite --csv")
def points(results: Stored = RESULT_FILE, as_csv: AsCsv = False, as_json: AsJson = False) -> None:
    """Print every point of every map and ensemble of a result file.

    The table is cut to 80 columns; --csv and --json have every number in full.
    """
    from ..run import running
    from ..run.brief_records import point_lines
    from ..sweeps.sweep_summary import flat_records

    records = [one for sweep in running.read(results).sweeps for one in flat_records(sweep)]
    if as_csv or as_json:
        _print_records(records, as_csv, as_json)
    else:
        _print_lines(point_lines(records))


@app.command(epilog="Example: spincheck tidy spincheck.sqlite")
def tidy(results: Stored = RESULT_FILE) -> None:
    """Delete results whose scene, engine or spincheck has changed since.

    'spincheck run' makes such results again, and keeps the old ones until they are deleted.
    """
    from ...results.result_file import ResultFileError
    from ...results.store import open_store

    with as_complaint(ResultFileError):
        with open_store(results):
            before = results.stat().st_size
        with open_store(results, create=True) as store:
            deleted = store.tidy()
    freed = before - results.stat().st_size
    print(f"{deleted} records deleted, {freed / MEGABYTE:.1f} MB freed")


def _print_lines(lines: Iterable[str]) -> None:
    from ....scenarios import printable

    for line in lines:
        print(printable(line))


def _print_records(records: list[dict[str, Any]], as_csv: bool, as_json: bool) -> None:
    from .csv_export import csv_text

    if as_csv and as_json:
        raise Complaint("takes '--csv' or '--json', not both", BAD_INPUT)
    if as_csv:
        print(csv_text(records), end="")
    else:
        print(to_json(records))
