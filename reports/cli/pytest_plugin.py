"""The pytest plugin: a scenario file is a test file.

It is loaded into every pytest run where the package is installed, so nothing heavy is imported
before a scenario file has been found.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from ...engines import Engine, Method, Missing
    from ...scenarios import Scenario
    from ..harness.executors import LocalWorkers
    from ..harness.study import Prepared

#: Bytes of a file's beginning in which a scenario's first key must be.
_HEAD = 1 << 14
#: What the reason of a skipped item begins with if the engine cannot simulate the scene.
_UNSUPPORTED = "unsupported: "
#: The keyword of the items of scenes.
_OWN = "spincheck_scene"
#: The property of an item whose outcome was known, so that it was not run.
_KEPT = "spincheck_kept"
#: The settings of which engines are tested, and of how many steps a run of a ladder may take.
_ENGINES, _MAX_STEPS = "spincheck_engines", "spincheck_max_steps"
#: Options of `spincheck.suite`.
ENGINE, XFAILS, SUITE = "--spincheck-engine", "--spincheck-xfails", "--spincheck-suite"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the settings of the plugin to pytest's configuration file."""
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
    group.addoption(
        SUITE, metavar="YYYY.MM", help="leave out tests that are newer than this version"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Check the settings, before anything is collected."""
    _asked_steps(config)
    if names := config.getoption(ENGINE):
        from .suite.hooks import SuiteHooks

        config.pluginmanager.register(
            SuiteHooks(names, config.getoption(XFAILS), config.getoption(SUITE))
        )


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Collect TOML files whose first key is `spincheck`; touch no other."""
    if file_path.suffix != ".toml" or not _may_be_scenario(file_path):
        return None
    from ...scenarios import is_scenario

    if not is_scenario(file_path):
        return None
    collector: pytest.Collector = ScenarioFile.from_parent(parent, path=file_path)
    return collector


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> None:
    """Compile the solver of exact motions before the first scene, and say so where it shows."""
    reporter: Any = session.config.pluginmanager.get_plugin("terminalreporter")
    has_scenes = any(isinstance(item, SceneItem) for item in session.items)
    if reporter is None or not has_scenes or session.config.option.collectonly:
        return
    from ..harness.executors.compiling import compile_first

    compile_first(reporter.write_line)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Say in a line how many methods on how many scenes agree, fail, or could not be judged."""
    own = {
        outcome: [r for r in terminalreporter.stats.get(outcome, []) if _is_own(r)]
        for outcome in ("passed", "failed", "skipped")
    }
    scenes = {report.nodeid.partition("::")[0] for reports in own.values() for report in reports}
    if not scenes:
        return
    unsupported = sum(_UNSUPPORTED in str(report.longrepr) for report in own["skipped"])
    open_ = len(own["skipped"]) - unsupported
    kept = sum((_KEPT, True) in r.user_properties for reports in own.values() for r in reports)
    terminalreporter.write_line(
        f"spincheck: scenes: {len(scenes)}; items that agree: {len(own['passed'])}, fail: "
        f"{len(own['failed'])}, do not support the scene: {unsupported}, skipped otherwise: {open_}"
        + (f"; known from before, not run ('--cache-clear' runs them): {kept}" if kept else "")
    )


def _is_own(report: Any) -> bool:
    """Whether it is of an item of a scene; other plugins may collect TOML files too."""
    return _OWN in getattr(report, "keywords", {})


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the worker, if one was started."""
    if worker := config.stash.get(_WORKER, None):
        worker.close()


class ScenarioFile(pytest.File):
    """One scene: an item for its reference, one for each engine and method."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield the items; an engine as shipped has one only where `[[expect]]` names it."""
        from ...engines import engines
        from ...scenarios import ScenarioError, load
        from ..harness.expectations import unknown_expectations

        if wrong := _unknown_engines(self.config):
            raise self.CollectError(wrong)
        try:
            self.scenario: Scenario = load(self.path)
        except ScenarioError as error:
            raise self.CollectError(str(error)) from None
        if unknown := unknown_expectations([self.scenario]):
            raise self.CollectError("\n".join(unknown))
        yield ReferenceItem.from_parent(self, name="reference")
        expected = {(expect.engine, expect.method) for expect in self.scenario.expect}
        names = {name for name, _ in expected}
        for engine in engines().values():
            chosen = _is_asked_for(self.config, engine, names, by_default=not engine.is_optional)
            if not (chosen and engine.applies_to(self.scenario)):
                continue
            made_for_it = engine.methods_for(self.scenario)
            for method in engine.methods:
                is_expected = (engine.name, method.name) in expected
                if (method.as_shipped or method not in made_for_it) and not is_expected:
                    continue
                name = f"{engine.name}-{method.name}"
                yield EngineItem.from_parent(self, name=name, engine=engine, method=method)
        yield from self._not_tested(names)

    def _not_tested(self, expected: set[str]) -> Iterator[pytest.Item]:
        """Yield an item for each engine that should be here and is not: it is skipped, not passed.

        Parameters
        ----------
        expected : engines that the scene has expectations of, which are asked for though optional
        """
        from importlib.metadata import requires

        from ...engines import missing

        needed = [line for line in requires("spincheck") or [] if "extra ==" not in line]
        for absent in missing():
            required = any(line.lower().startswith(absent.name.lower()) for line in needed)
            if _is_asked_for(self.config, absent, expected, by_default=required):
                yield MissingEngineItem.from_parent(self, name=absent.name, reason=absent.reason)

    @cached_property
    def prepared(self) -> "Prepared":
        """The scene's exact motion, solved once for all items."""
        from ..harness.study import prepare

        timesteps = sorted({expect.timestep for expect in self.scenario.expect})
        prepared = prepare(self.scenario, timesteps, _max_steps(self.config))
        # Timesteps above the ladder are for the report only.
        return replace(prepared, ladder=replace(prepared.ladder, above=()))


class SceneItem(pytest.Item):
    """An item whose failure is one message, not a stack trace."""

    parent: ScenarioFile

    def __init__(self, **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.keywords[_OWN] = True

    def reportinfo(self) -> tuple[Path, None, str]:
        """File, line (none) and name of the item, for pytest's report."""
        return self.path, None, f"{self.path.stem}::{self.name}"

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Show what disagreed; only a fault of this program shows its trace."""
        if isinstance(excinfo.value, Disagreement):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)


class Disagreement(Exception):
    """What an item found, in words."""


class ReferenceItem(SceneItem):
    """Checks the reference: invariants, a cross-check, published values."""

    def runtest(self) -> None:
        """Raise `Disagreement` with all complaints."""
        from ..harness.reference_checks import complaints

        wrong = list(complaints(self.parent.scenario))
        if wrong:
            command = f"reproduce with: spincheck reference {self.path}"
            raise Disagreement("\n".join([*wrong, command]))


class EngineItem(SceneItem):
    """Runs one method of one engine down its ladder and judges it."""

    def __init__(self, *, engine: "Engine", method: "Method", **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.engine = engine
        self.method = method

    def runtest(self) -> None:
        """Skip it, or raise `Disagreement`; it is not run if nothing it rests on has changed."""
        from .kept_items import keep, outcome_of, rests_on

        scenario = self.parent.scenario
        if reason := self.engine.unsupported(scenario, self.method):
            skipped = f"{_UNSUPPORTED}{reason}"
        else:
            digest = rests_on(scenario, self.engine, self.method, _max_steps(self.config))
            kept = outcome_of(self, digest)
            skipped = self._skipped() if kept is None else kept
            self.user_properties.append((_KEPT, kept is not None))
            keep(self, digest, skipped)
        if skipped:
            pytest.skip(f"{scenario.name}, {self.engine.name} {self.method.name}: {skipped}")

    def _skipped(self) -> str:
        """Run it; returns why it is neither a pass nor a failure, empty if it passes.

        Raises
        ------
        Disagreement
            If it disagrees, or is unresolved.
        """
        from ..harness.judging import judge
        from ..harness.study import convergence_study_of, run_rungs

        scenario = self.parent.scenario
        study = convergence_study_of(scenario, self.engine, self.method, self.parent.prepared)
        for _ in run_rungs(study, _worker(self.config)):
            pass
        verdict = judge(study.records)
        is_open = verdict.verdict == "unresolved" and verdict.is_unproven
        if not verdict.agrees or is_open:
            raise Disagreement(
                "\n".join(
                    [
                        *verdict.unmet,
                        f"{verdict.verdict}: {verdict.reason}",
                        f"reproduce with: spincheck run {self.path} "
                        f"--engine {self.engine.name} --method {self.method.name}",
                        *self._remedies(verdict.unmet),
                    ]
                )
            )
        if verdict.verdict != "converges" and not (verdict.as_shipped or verdict.expected_failure):
            return f"{verdict.verdict}: {verdict.reason}"
        return ""

    def _remedies(self, unmet: Sequence[str]) -> Iterator[str]:
        """The commands that find a timestep at which the bounds of unmet expectations hold."""
        from .grouped import option

        own = (self.engine.name, self.method.name)
        for expect in self.parent.scenario.expect:
            if unmet and expect.bounds() and (expect.engine, expect.method) == own:
                bounds = (f"{option(name)} {bound:g}" for name, bound in expect.bounds().items())
                words = ["spincheck recommend", str(self.path), "--engine", own[0], *bounds]
                yield f"a method and timestep that keep it: {' '.join(words)}"


class MissingEngineItem(SceneItem):
    """Says that an engine was not tested, and why."""

    def __init__(self, *, reason: str, **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.reason = reason

    def runtest(self) -> None:
        """Skip."""
        pytest.skip(f"not tested: {self.reason}")


def _max_steps(config: pytest.Config) -> int:
    """Steps that a run of a ladder may take."""
    from ..harness.ladder import MAX_STEPS

    return min(_asked_steps(config) or MAX_STEPS, MAX_STEPS)


def _asked_steps(config: pytest.Config) -> int | None:
    """The setting of the number of steps; None if it is left out."""
    setting = config.getini(_MAX_STEPS)
    if not setting:
        return None
    if not (setting.isdecimal() and int(setting)):
        raise pytest.UsageError(f"'{_MAX_STEPS}' must be a whole number from 1 on, got '{setting}'")
    return int(setting)


def _is_asked_for(
    config: pytest.Config, engine: "Engine | Missing", expected: set[str], *, by_default: bool
) -> bool:
    """Whether items are made for an engine.

    Parameters
    ----------
    expected : engines that the scene has expectations of
    by_default : whether there are items if it has none and no setting names engines
    """
    if names := config.getini(_ENGINES):
        return not {"all", engine.name, engine.family or engine.name}.isdisjoint(names)
    return engine.name in expected if expected else by_default


def _unknown_engines(config: pytest.Config) -> str:
    """The complaint about an unknown engine in the settings; empty if all are known."""
    from ...engines import engines, missing
    from ...scenarios import did_you_mean

    known: list[Engine | Missing] = [*engines().values(), *missing()]
    names = ["all", *sorted({one.name for one in known} | {one.family for one in known} - {""})]
    for name in config.getini(_ENGINES):
        if name not in names:
            one_of = f"'{_ENGINES}' must be of {', '.join(names)}, got '{name}'"
            return one_of + did_you_mean(name, names)
    return ""


_WORKER: "pytest.StashKey[LocalWorkers]" = pytest.StashKey()


def _worker(config: pytest.Config) -> "LocalWorkers":
    """One worker process for the session: a crash costs the item, not the run."""
    from ..harness.executors import LocalWorkers

    if _WORKER not in config.stash:
        config.stash[_WORKER] = LocalWorkers(jobs=1)
    return config.stash[_WORKER]


def _may_be_scenario(path: Path) -> bool:
    try:
        # Reading from a pipe would block.
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return b"spincheck" in file.read(_HEAD)
    except OSError:
        return False
