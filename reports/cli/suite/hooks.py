"""The hooks of pytest of `spincheck.suite`, registered where an engine is named."""

import tomllib
from collections.abc import Generator
from pathlib import Path
from typing import Any, TypeGuard

import pytest
from spincheck.suite import SCENES, VERSION

from ....scenarios import did_you_mean
from ....suite import test_adapter, test_physics
from .subjects import subjects

TESTS = [name for name in [*vars(test_adapter), *vars(test_physics)] if name.startswith("test_")]


def known_failures(path: Path) -> dict[str, str]:
    """Return the reasons by the names of tests: ``test_heavy_top``, or with ``[engine-method]``.

    The file is TOML, a line ``"test_heavy_top[my-engine-RK4]" = "reason"`` for each.

    Raises
    ------
    pytest.UsageError
        If it cannot be read, or names a test that there is not, or one without a reason.
    """
    where = f"'--spincheck-xfails' {path}"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise pytest.UsageError(f"{where}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise pytest.UsageError(f"{where}: must be TOML in UTF-8: {error}") from None
    for name, reason in table.items():
        test = name.partition("[")[0]
        if test not in TESTS:
            hint = did_you_mean(test, TESTS)
            raise pytest.UsageError(f"{where}: '{test}' is no test of the suite{hint}")
        if not (isinstance(reason, str) and reason.strip()):
            raise pytest.UsageError(
                f"{where}: '{name}' must have its reason as a text, got {reason!r}"
            )
    return table


#: What a test of the suite is parametrised by.
SUBJECT = "spincheck_subject"
_FOLDER = SCENES.parent.resolve()


class SuiteHooks:
    """One run of the suite.

    Parameters
    ----------
    engines : as typed
    xfails : a file of known failures, as typed
    version : of the suite, whose tests are run; the newest if None

    Raises
    ------
    pytest.UsageError
        If an engine, the file or the version cannot be used.
    """

    def __init__(self, engines: list[str], xfails: str | None, version: str | None) -> None:
        self._subjects = list(subjects(engines))
        self._known = known_failures(Path(xfails)) if xfails else {}
        self._version = version or VERSION
        if self._version > VERSION:
            raise pytest.UsageError(
                f"'--spincheck-suite' must be {VERSION} or older, got '{version}'; a newer "
                "spincheck has a newer suite"
            )

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Repeat each test for each method of the engines."""
        if SUBJECT in metafunc.fixturenames:
            ids = [subject.name for subject in self._subjects]
            metafunc.parametrize(SUBJECT, self._subjects, ids=ids)

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Leave out tests that are newer than the version asked for; mark known failures."""
        ours = [item for item in items if _is_of_suite(item)]
        newer = [item for item in ours if vars(item.function)["since"] > self._version]
        if newer:
            config.hook.pytest_deselected(items=newer)
            items[:] = [item for item in items if item not in newer]
        for item in ours:
            reason = self._known.get(item.name) or self._known.get(item.originalname)
            if reason:
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Say what a failure means, and which public issues the test would have caught."""
        report = yield
        if _is_of_suite(item) and report.failed:
            about = vars(item.function)
            lines = [about["sentence"], *about["issues"]]
            report.sections.append(("what this failure means", "\n".join(lines)))
        return report

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Name the suite's version and what it was run on."""
        names = ", ".join(dict.fromkeys(subject.about for subject in self._subjects))
        terminalreporter.write_line(f"spincheck suite {self._version} on {names}")


def _is_of_suite(item: pytest.Item) -> TypeGuard[pytest.Function]:
    return isinstance(item, pytest.Function) and item.path.resolve().parent == _FOLDER
