"""Fixtures of more than one folder."""

import pytest


@pytest.fixture
def engines_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The items of scenario files run their engines in this process."""
    from spincheck.reports.cli import pytest_plugin
    from spincheck.reports.harness.executors import InProcess

    monkeypatch.setattr(pytest_plugin, "_worker", lambda _: InProcess())
