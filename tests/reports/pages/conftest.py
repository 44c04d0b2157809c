"""Fixtures of more than one file: the made-up report, and the runs of its top."""

from pathlib import Path

import pytest
from made_up import results
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.render import render


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report on the made-up results; to be read only."""
    folder = tmp_path_factory.mktemp("report")
    render(results(), folder)
    return folder


@pytest.fixture(scope="session")
def top() -> SceneRuns:
    """The runs of the made-up top."""
    return next(scene for scene in report_data(results()).scenes if scene.name == "made-up-top")
