"""Reads result files while another process writes them."""

import sqlite3
import subprocess
import time
from contextlib import closing
from pathlib import Path


def rows_in(path: Path, table: str = "rows") -> int:
    """Records in a table of a file that is perhaps just being begun."""
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as connection:
            return int(connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


def wait_for_rows(run: subprocess.Popen[str], path: Path, rows: int, table: str = "rows") -> None:
    """Until so many records are there, or the run has ended before its time."""
    while rows_in(path, table) < rows:
        assert run.poll() is None, run.communicate()
        time.sleep(0.01)
