"""Pytest hooks of `spincheck.suite`, and the subjects that it tests.

The hooks are registered if '--spincheck-engine' is given.
"""

import tomllib
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeGuard, final

import pytest
from spincheck.suite import SCENES, test_adapter, test_physics

from ....engines import Engine, Method, engines, missing
from ....scenarios import Scenario, did_you_mean, load
from ...harness.executors import InProcess
from ...harness.prepared import Prepared, prepare
from ...harness.recorded.files.read import READERS, read_recording
from ...harness.recorded.files.recording import RecordingError
from ...harness.recorded.judged import judged_motion
from ...harness.recorded.recorded_ladder import FEWEST_FILES, study_of_files, verdict_on_files
from ...harness.study import convergence_study_of, run_and_judge
from ...results.verdict_words import VERDICT
from ...results.verdicts import Verdict
from ..choosing import choose
from ..terminal import Complaint

#: Number of steps of the longest run, which takes a quarter of a second at 15 µs a step.
MOST_STEPS = 1 << 14


class Subject(ABC):
    """The subject of a test: a method of an engine, or recorded motions.

    Attributes
    ----------
    name : name in the ids of tests
    about : the engine and its version, or the folder of the recorded motions
    method : the engine's method; None for recorded motions
    """

    name: str
    about: str
    method: Method | None = None

    def follows(self, name: str) -> None:
        """Fail the test if the verdict on a scene is `disagrees`, `failed` or `diverges`.

        The test is skipped if the verdict is `unresolved` or `unsupported`.

        Parameters
        ----------
        name : name of one of the suite's scenes
        """
        verdict = self._verdict(name)
        word, reason = verdict.verdict, verdict.reason
        if VERDICT[word].fails or word == "diverges":
            pytest.fail(f"it {word}: {reason}\nscene: {SCENES / name}.toml", pytrace=False)
        if word != "converges":
            pytest.skip(f"{word}: {reason}")

    @abstractmethod
    def _verdict(self, name: str) -> Verdict:
        """Return the verdict on the subject for one of the suite's scenes, by the scene's name."""


@final
@dataclass(eq=False)
class EngineSubject(Subject):
    """A method of an engine, run at each timestep of a ladder in this process."""

    engine: Engine
    method: Method

    def __post_init__(self) -> None:
        self.name = f"{self.engine.name}-{self.method.name}"
        self.about = f"{self.engine.name} {self.engine.version}"
        self._verdicts: dict[str, Verdict] = {}

    def _verdict(self, name: str) -> Verdict:
        """Return the verdict on a scene; only the first call for a scene runs the method."""
        if name not in self._verdicts:
            scenario, prepared = _scene(name), _prepared(name)
            study = convergence_study_of(scenario, self.engine, self.method, prepared)
            self._verdicts[name] = run_and_judge(study, InProcess())
        return self._verdicts[name]


@final
@dataclass(eq=False)
class RecordedSubject(Subject):
    """Motions recorded elsewhere: a folder for each scene, with a file for each timestep.

    Attributes
    ----------
    folder : the folder that contains the scenes' folders
    """

    folder: Path

    def __post_init__(self) -> None:
        self.name, self.about = self.folder.name, str(self.folder)

    def _verdict(self, name: str) -> Verdict:
        """Return the verdict on the recorded motions of a scene.

        The test fails if a file cannot be read; it is skipped if there are fewer than
        `FEWEST_FILES` files. If a known mistake explains the errors at the finest timestep, a
        verdict other than `converges` becomes `disagrees`.
        """
        files = sorted(
            file for file in (self.folder / name).glob("*") if file.suffix.lower() in READERS
        )
        if len(files) < FEWEST_FILES:
            pytest.skip(
                f"{self.folder / name} must hold {FEWEST_FILES} motions or more of {SCENES / name}"
                f".toml, at halved timesteps (docs/how-to/judge.md), got {len(files)}"
            )
        scenario = _scene(name)
        try:
            motions = [judged_motion(scenario, read_recording(file)) for file in files]
            verdict = verdict_on_files(study_of_files(scenario, motions, order=1))
        except RecordingError as error:
            pytest.fail(f"{self.folder / name}: {error}", pytrace=False)
        finest = min(motions, key=lambda one: one.timestep or 0.0)
        if not finest.explained_by or verdict.verdict == "converges":
            return verdict
        quoted = "; ".join(filter(None, [*finest.explained_by, verdict.quoted]))
        return replace(verdict, verdict="disagrees", quoted=quoted)


@cache
def _scene(name: str) -> Scenario:
    """Return one of the suite's scenes, by its name."""
    return load(SCENES / f"{name}.toml")


@cache
def _prepared(name: str) -> Prepared:
    """Return ladder and exact motion of one of the suite's scenes.

    No run of the ladder takes more than `MOST_STEPS` steps.
    """
    return prepare(_scene(name), (), MOST_STEPS).for_verdicts()


def subjects(names: list[str]) -> Iterator[Subject]:
    """Yield the subjects that `--spincheck-engine` names.

    Parameters
    ----------
    names : engines, or folders of recorded motions

    Raises
    ------
    pytest.UsageError
        If there is no such engine or it cannot be used; the message has the reason.
    """
    for name in names:
        if Path(name).is_dir():
            yield RecordedSubject(Path(name).resolve())
            continue
        for engine in _engines(name):
            yield from (EngineSubject(engine, method) for method in engine.methods)


def _engines(name: str) -> tuple[Engine, ...]:
    """Return the engines that a value of `--spincheck-engine` names.

    `pytest.UsageError` is raised if there are none.
    """
    try:
        return choose([name], [], []).engines
    except Complaint as error:
        words = str(error).replace("'--engine'", "'--spincheck-engine'")
        raise pytest.UsageError(words) from None


TESTS = [name for name in [*vars(test_adapter), *vars(test_physics)] if name.startswith("test_")]


def known_failures(path: Path, tested: Sequence[Subject]) -> dict[str, str]:
    """Return the reasons of known failures from a file, by the names or ids of tests.

    The file is TOML, with a line ``"test_heavy_top[my-engine-RK4]" = "reason"`` for each test. A
    line without the brackets holds for every engine and method.

    Parameters
    ----------
    path : the file
    tested : all methods of the engines that are tested, and recorded motions

    Raises
    ------
    pytest.UsageError
        If the file cannot be read, or if one of its lines names a test that does not exist, names a
        method that its engine lacks, or gives no reason.
    """
    where = f"'--spincheck-xfails' {path}"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise pytest.UsageError(f"{where}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise pytest.UsageError(f"{where}: must be TOML in UTF-8: {error}") from None
    for name, reason in table.items():
        test, _, subject = name.partition("[")
        if test not in TESTS:
            hint = did_you_mean(test, TESTS)
            raise pytest.UsageError(f"{where}: '{test}' is no test of the suite{hint}")
        engine = _engine_of(subject)
        of_engine = (one for one in tested if isinstance(one, EngineSubject))
        ids = [f"{test}[{one.name}]" for one in of_engine if one.engine.name == engine]
        if ids and name not in ids:
            hint = did_you_mean(name, ids)
            raise pytest.UsageError(f"{where}: '{name}' names no method of {engine}{hint}")
        if not (isinstance(reason, str) and reason.strip()):
            raise pytest.UsageError(
                f"{where}: '{name}' must have its reason as a text, got {reason!r}"
            )
    return table


def _engine_of(subject: str) -> str:
    """Return the name of the engine with which a subject's name begins; empty if there is none.

    If the names of several engines fit, the longest is returned.
    """
    known = [*engines(), *(one.name for one in missing())]
    return max((one for one in known if subject.startswith(f"{one}-")), key=len, default="")


#: Name of the argument by which tests of the suite are parametrised.
SUBJECT = "spincheck_subject"
_FOLDER = SCENES.parent.resolve()


class SuiteHooks:
    """The pytest hooks for one run of the suite.

    Parameters
    ----------
    engines : names of engines, or folders of recorded motions, as typed
    xfails : path of a file of known failures, as typed; None if there is none

    Raises
    ------
    pytest.UsageError
        If an engine or the file cannot be used.
    """

    def __init__(self, engines: list[str], xfails: str | None) -> None:
        self._subjects = list(subjects(engines))
        self._known = known_failures(Path(xfails), self._subjects) if xfails else {}

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Parametrise the tests of the suite, so that each is run on every subject."""
        if SUBJECT in metafunc.fixturenames:
            ids = [subject.name for subject in self._subjects]
            metafunc.parametrize(SUBJECT, self._subjects, ids=ids)

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Mark the tests that are known to fail as expected failures."""
        for item in filter(_is_of_suite, items):
            reason = self._known.get(item.name) or self._known.get(item.originalname)
            if reason:
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Add to the report of a failure what it means, and issues that the test would have caught.

        The hook wraps pytest's own hook, and returns its report.
        """
        report = yield
        if _is_of_suite(item) and report.failed:
            about = vars(item.function)
            lines = [about["sentence"], *about["issues"]]
            report.sections.append(("what this failure means", "\n".join(lines)))
        return report

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Print the engines with their versions, or the folders, that the suite was run on."""
        names = ", ".join(dict.fromkeys(subject.about for subject in self._subjects))
        terminalreporter.write_line(f"spincheck suite on {names}")


def _is_of_suite(item: pytest.Item) -> TypeGuard[pytest.Function]:
    """Whether a test is one of the suite."""
    return isinstance(item, pytest.Function) and item.path.resolve().parent == _FOLDER
