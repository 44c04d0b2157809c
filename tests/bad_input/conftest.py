"""Fixtures of more than one file."""

from pathlib import Path

import pytest
import small_result_file


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result file without a fault; tests damage copies of it."""
    return small_result_file.write(tmp_path_factory.mktemp("good") / "good.sqlite")
