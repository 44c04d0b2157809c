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
    rows : the runs in which nothing is varied; those of ensembles are left out
    verdicts : one for each scene and method: that on its ladder, or else the latest
    """

    rows: list[Row]
    verdicts: list[Verdict]

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the runs and verdicts in a result file.

        It raises `ResultFileError` as `spincheck.results` does.
        """
        with open_store(path) as store:
            results = store.read()
        return cls(results.rows, results.verdicts)

    def rows_frame(self) -> Any:
        """Return the runs as a pandas `DataFrame` with a column for each field.

        The errors are in columns of their own, as in `errors.omega`; motions are left out.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _frame(asdict(replace(row, motion=None)) for row in self.rows)

    def verdicts_frame(self) -> Any:
        """Return the verdicts as a pandas `DataFrame` with a column for each field.

        Each property that `MADE` names has a column, too.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _frame(
            asdict(one) | {name: getattr(one, name) for name in MADE} for one in self.verdicts
        )


def _frame(records: Iterable[dict[str, Any]]) -> Any:
    return import_module("pandas").json_normalize(list(records))
