"""The pytest plugin: a scenario file is a test file.

It is loaded into every pytest run where the package is installed, so nothing heavy is imported
before a scenario file has been found.
"""

from pathlib import Path
from typing import Any

import pytest

from .scene_summary import KEPT, summary

#: Number of bytes at a file's beginning in which a scenario's first key must be.
_HEAD = 1 << 14
#: Names of two settings of pytest: the engines tested, and the largest number of steps of a run.
_ENGINES, _MAX_STEPS = "spincheck_engines", "spincheck_max_steps"
#: Options of `spincheck.suite`.
ENGINE, XFAILS = "--spincheck-engine", "--spincheck-xfails"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the plugin's settings and its command-line options to those that pytest knows."""
    parser.addini(
        _ENGINES,
        "engines that spincheck's scenes are run on, or 'all'; if left out, those that a scene's "
        "[[expect]] names, else all but the optional ones",
        "args",
    )
    parser.addini(
        _MAX_STEPS,
        "ladders of spincheck's scenes end before a run would take more steps; "
        "as long as those of 'spincheck run' if left out",
        default="",
    )

    group = parser.getgroup("spincheck", "spincheck.suite, tests of a physics engine")
    group.addoption(
        ENGINE,
        action="append",
        metavar="ENGINE",
        help="what the suite tests: my_package:MyEngine, an engine of 'spincheck engines', "
        "'child:COMMAND', or a folder of recorded motions; may be repeated",
    )
    group.addoption(
        XFAILS, metavar="FILE", help="TOML: the tests that are known to fail, each with its reason"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Check the plugin's settings; if '--spincheck-engine' is given, register the suite's hooks.

    `pytest.UsageError` is raised for a setting or an option that cannot be used.
    """
    _max_steps(config)
    if names := config.getoption(ENGINE):
        from .suite.hooks import SuiteHooks

        config.pluginmanager.register(SuiteHooks(names, config.getoption(XFAILS)))


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Return a collector for a TOML file whose first key is `spincheck`, None for others."""
    if file_path.suffix != ".toml" or not _may_be_scenario(file_path):
        return None
    from ...scenarios import is_scenario

    if not is_scenario(file_path):
        return None
    from .scene_items import SceneFile

    engines, max_steps = parent.config.getini(_ENGINES), _max_steps(parent.config)
    collector: pytest.Collector = SceneFile.from_parent(
        parent, path=file_path, engines=engines, max_steps=max_steps
    )
    return collector


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> None:
    """Compile the solver of exact motions before the first test, and print a message about it.

    Nothing is done if there are no scenes among the tests, or if no test will be run.
    """
    reporter: Any = session.config.pluginmanager.get_plugin("terminalreporter")
    has_scenes = any(KEPT in dict(item.user_properties) for item in session.items)
    option = session.config.option
    is_interrupted = session.testsfailed and not option.continue_on_collection_errors
    if reporter is None or not has_scenes or option.collectonly or is_interrupted:
        return
    from ..harness.executors.compiling import compile_first

    compile_first(reporter.write_line)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print how many of the scenes' test items agree, fail, or were not judged."""
    if line := summary(terminalreporter.stats):
        terminalreporter.write_line(line)


def _max_steps(config: pytest.Config) -> int | None:
    """Return the largest number of steps of a run, from pytest's settings; None if not set.

    `pytest.UsageError` is raised unless the setting is a whole number from 1 on.
    """
    setting = config.getini(_MAX_STEPS)
    if not setting:
        return None
    if not (setting.isdecimal() and int(setting)):
        raise pytest.UsageError(f"'{_MAX_STEPS}' must be a whole number from 1 on, got '{setting}'")
    return int(setting)


def _may_be_scenario(path: Path) -> bool:
    """Whether a path is that of a regular file with the word "spincheck" near its beginning."""
    try:
        # Only a regular file, as reading from a pipe would block.
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return b"spincheck" in file.read(_HEAD)
    except OSError:
        return False
