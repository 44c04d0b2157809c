"""The contents of a result file for scripts and notebooks."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Self, final

from spincheck.reports.results.records import Row
from spincheck.reports.results.store import open_store
from spincheck.reports.results.verdicts import MADE, Verdict


@final
@dataclass(frozen=True, eq=False)
class StoredResults:
    """Runs and verdicts of a result file, as records or, with pandas, as a `DataFrame` each.

    Attributes
    ----------
    rows : the runs, without those on members of ensembles and those of engines with some defaults
        switched off
    verdicts : one for each scene and method: the verdict on its ladder; if there is none, the
        latest verdict
    """

    rows: list[Row]
    verdicts: list[Verdict]

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the runs and verdicts in a result file.

        `ResultFileError` is raised if the file is missing or cannot be read.
        """
        with open_store(path) as store:
            results = store.read()
        return cls(results.rows, results.verdicts)

    def rows_frame(self) -> Any:
        """Return the runs as a pandas `DataFrame` with a column for each field.

        The error in each signal has a column of its own, such as `errors.omega`. Motions are left
        out.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _frame(asdict(replace(row, motion=None)) for row in self.rows)

    def verdicts_frame(self) -> Any:
        """Return the verdicts as a pandas `DataFrame` with a column for each field.

        The properties `reason`, `tail`, `level`, `order` and `ground` have columns, too.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _frame(
            asdict(one) | {name: getattr(one, name) for name in MADE} for one in self.verdicts
        )


def _frame(records: Iterable[dict[str, Any]]) -> Any:
    """Return records as a pandas `DataFrame`; a nested value has the column "outer.inner"."""
    return import_module("pandas").json_normalize(list(records))
