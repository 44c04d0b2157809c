"""Fixtures of more than one file: a result file to be begun, what is stored, a clock, pytest."""

from collections.abc import Callable
from pathlib import Path

import pytest
from _pytest.pytester import Pytester, RunResult, SysModulesSnapshot
from clockwork import clock
from spincheck.reports.results.records import Record, Row
from spincheck.reports.results.store import Store

__all__ = ["clock"]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Where a result file may be begun."""
    return tmp_path / "results.sqlite"


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[Row]:
    """The rows stored from now on."""
    stored: list[Row] = []
    put = Store.put

    def counting(store: Store, *records: Record) -> None:
        put(store, *records)
        stored.extend(record for record in records if isinstance(record, Row))

    monkeypatch.setattr(Store, "put", counting)
    return stored


@pytest.fixture
def run_pytest(pytester: Pytester, monkeypatch: pytest.MonkeyPatch) -> Callable[..., RunResult]:
    """Run pytest in this process, for modules with the plugin `pytester`."""
    # pytester would forget what is imported meanwhile, and numba imports its parts but once.
    keeping_all = SysModulesSnapshot(preserve=lambda _: True)
    monkeypatch.setattr(pytester, "_sys_modules_snapshot", keeping_all)
    monkeypatch.setattr(pytester, "_Pytester__take_sys_modules_snapshot", lambda: keeping_all)
    return lambda *arguments: pytester.runpytest_inprocess("-p", "no:cacheprovider", *arguments)
