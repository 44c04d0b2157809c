"""Fixtures of the suite's tests: the engines named on pytest's command line."""

from typing import Any

import pytest
from spincheck.engines import Engine, Method

#: Files of scenes: pytest must not collect them, as they are data of tests, not tests.
collect_ignore_glob = ["scenes/*"]


@pytest.fixture
def spincheck_subject() -> Any:
    """Return the subject of a test: a method of an engine, or recorded motions.

    If '--spincheck-engine' is given, the plugin provides the subjects in place of this fixture.
    The fixture itself runs only without that option, and ends pytest with a message.
    """
    pytest.exit(
        "'--spincheck-engine' must name what is tested: my_package:MyEngine, an engine of "
        "'spincheck engines', 'child:COMMAND', or a folder of recorded motions.",
        returncode=pytest.ExitCode.USAGE_ERROR,
    )


@pytest.fixture
def method(spincheck_subject: Any) -> Method:
    """The method that is tested; a test of recorded motions, which have none, is skipped."""
    if spincheck_subject.method is None:
        pytest.skip("needs the engine itself, recorded motions do not show it")
    method: Method = spincheck_subject.method
    return method


@pytest.fixture
def engine(spincheck_subject: Any, method: Method) -> Engine:  # noqa: ARG001
    """The engine that is tested; `method` is asked for so that recorded motions are skipped."""
    engine: Engine = spincheck_subject.engine
    return engine
