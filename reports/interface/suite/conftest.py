"""What the tests of the suite are given: the engines named on pytest's command line."""

from typing import Any

import pytest
from spincheck.engines import Engine, Method

#: Scenes are data of tests, and none themselves.
collect_ignore_glob = ["scenes/*"]


@pytest.fixture
def spincheck_subject() -> Any:
    """What is tested; parametrised by spincheck's plugin if an engine is named."""
    pytest.exit(
        "'--spincheck-engine' must name what is tested: my_package:MyEngine, an engine of "
        "'spincheck engines', 'child:COMMAND', or a folder of recorded motions.",
        returncode=pytest.ExitCode.USAGE_ERROR,
    )


@pytest.fixture
def method(spincheck_subject: Any) -> Method:
    """A method of the engine."""
    if spincheck_subject.method is None:
        pytest.skip("needs the engine itself, recorded motions do not show it")
    method: Method = spincheck_subject.method
    return method


@pytest.fixture
def engine(spincheck_subject: Any, method: Method) -> Engine:  # noqa: ARG001
    """The engine that is tested."""
    engine: Engine = spincheck_subject.engine
    return engine
