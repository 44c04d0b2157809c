"""Pytest's items for a scene: one for its reference, one for each engine and method."""

import shlex
from collections.abc import Iterator
from functools import cached_property
from importlib.metadata import requires
from pathlib import Path
from typing import Any

import pytest

from ...engines import Engine, Method, Missing, NameTaken, engines, missing
from ...scenarios import ScenarioError, did_you_mean, load
from ..harness.executors import LocalWorkers
from ..harness.prepared import Prepared, prepare
from ..harness.scene_checks.expectations import unknown_expectations
from ..harness.scene_checks.reference_checks import complaints
from ..harness.study import convergence_study_of, run_and_judge
from ..harness.timesteps.ladder import MAX_STEPS
from .grouped import option
from .kept_items import keep, outcome_of, rests_on
from .scene_summary import KEPT, UNSUPPORTED


class SceneFile(pytest.File):
    """One scene's file, whose items pytest collects.

    Parameters
    ----------
    engines : names of the engines to test, from pytest's settings; if empty, those that the scene's
        `[[expect]]` tables name; if there are none, all but optional engines
    max_steps : largest number of steps of a run, from pytest's settings; None if not set
    """

    def __init__(self, *, engines: list[str], max_steps: int | None, **parent: Any) -> None:
        super().__init__(**parent)
        self._engines = engines
        self.max_steps = min(max_steps or MAX_STEPS, MAX_STEPS)

    def collect(self) -> Iterator[pytest.Item]:
        """Yield an item for the reference, and one for each engine and method.

        A method as shipped, or one that its engine does not offer for the scene, has an item only
        if an `[[expect]]` table names it. A missing engine has an item that is skipped.

        Raises
        ------
        CollectError
            If the scene or a setting cannot be used.
        """
        self._check_engines()
        try:
            self.scenario = load(self.path)
        except ScenarioError as error:
            raise self.CollectError(str(error)) from None
        if unknown := unknown_expectations([self.scenario]):
            raise self.CollectError("\n".join(unknown))
        yield ReferenceItem.from_parent(self, name="reference")
        expected = {(expect.engine, expect.method) for expect in self.scenario.expect}
        for engine in engines().values():
            is_chosen = self._is_chosen(engine, by_default=not engine.is_optional)
            if not (is_chosen and engine.applies_to(self.scenario)):
                continue
            made_for_it = engine.methods_for(self.scenario)
            for method in engine.methods:
                is_expected = (engine.name, method.name) in expected
                if (method.as_shipped or method not in made_for_it) and not is_expected:
                    continue
                name = f"{engine.name}-{method.name}"
                yield EngineItem.from_parent(self, name=name, engine=engine, method=method)
        yield from self._not_tested()

    def _check_engines(self) -> None:
        """Raise `CollectError` for an unknown engine in the settings, or two of the same name."""
        try:
            known: list[Engine | Missing] = [*engines().values(), *missing()]
        except NameTaken as error:
            raise self.CollectError(str(error)) from None
        names = ["all", *sorted({one.name for one in known} | {one.family for one in known} - {""})]
        for name in self._engines:
            if name not in names:
                raise self.CollectError(
                    f"'spincheck_engines' must be of {', '.join(names)}, got '{name}'"
                    + did_you_mean(name, names)
                )

    def _is_chosen(self, engine: Engine | Missing, *, by_default: bool) -> bool:
        """Whether the engine is one of those to test.

        Parameters
        ----------
        by_default : the answer if no setting names engines and the scene has no `[[expect]]`
        """
        if self._engines:
            names = {"all", engine.name, engine.family or engine.name}
            return not names.isdisjoint(self._engines)
        expected = {expect.engine for expect in self.scenario.expect}
        return engine.name in expected if expected else by_default

    def _not_tested(self) -> Iterator[pytest.Item]:
        """Yield an item that is skipped for each engine that should be installed but is missing.

        Engines that the settings or the scene's expectations name should be installed; if these
        name none, the engines that the package requires should be.
        """
        needed = [line for line in requires("spincheck") or [] if "extra ==" not in line]
        for absent in missing():
            required = any(line.lower().startswith(absent.name.lower()) for line in needed)
            if self._is_chosen(absent, by_default=required):
                yield MissingEngineItem.from_parent(self, name=absent.name, reason=absent.reason)

    @cached_property
    def prepared(self) -> Prepared:
        """The scene's ladder and exact motion; the motion is solved once for all items."""
        timesteps = sorted({expect.timestep for expect in self.scenario.expect})
        return prepare(self.scenario, timesteps, self.max_steps).for_verdicts()


class SceneItem(pytest.Item):
    """A test item of a scene; its failure is reported as one message, not as a stack trace."""

    parent: SceneFile

    def __init__(self, **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.user_properties.append((KEPT, False))

    @property
    def typed(self) -> str:
        """The path of the scene's file, quoted as it has to be in a command."""
        return shlex.quote(str(self.path))

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return file, line (None) and name of the item, for pytest's report."""
        return self.path, None, f"{self.path.stem}::{self.name}"

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return what pytest reports of a failure.

        For a `Disagreement`, it is what disagreed, in words; for any other error, a stack trace.
        """
        if isinstance(excinfo.value, Disagreement):
            return "\n".join(excinfo.value.args)
        return super().repr_failure(excinfo, style)


class Disagreement(Exception):
    """The error of a test item that fails; its arguments are lines that say what disagreed."""


class ReferenceItem(SceneItem):
    """The item that checks the reference: invariants, a cross-check, published values."""

    def runtest(self) -> None:
        """Raise `Disagreement` with all complaints about the reference, if there are any."""
        if wrong := list(complaints(self.parent.scenario)):
            raise Disagreement(*wrong, f"reproduce with: spincheck reference {self.typed}")


class EngineItem(SceneItem):
    """The item that runs one method of one engine at the timesteps of a ladder and judges it."""

    def __init__(self, *, engine: Engine, method: Method, **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.engine = engine
        self.method = method

    def runtest(self) -> None:
        """Run and judge the method on the scene.

        The item is skipped if the method does not support the scene or diverges. The method is not
        run if its outcome is kept from an earlier session and nothing that the outcome depends on
        has changed since.

        Raises
        ------
        Disagreement
            If the verdict is `disagrees`, `failed` or `unresolved` and this is not expected, or if
            an expectation of the scene is unmet.
        """
        scenario, engine, method = self.parent.scenario, self.engine, self.method
        if reason := engine.unsupported(scenario, method):
            skipped: str | None = f"{UNSUPPORTED}: {reason}"
        else:
            digest = rests_on(scenario, engine, method, self.parent.max_steps)
            skipped = outcome_of(self, digest)
            if skipped is None:
                skipped = self._skipped()
                keep(self, digest, skipped)
            else:
                self.user_properties[:] = [(KEPT, True)]
        if skipped:
            pytest.skip(f"{scenario.name}, {engine.name} {method.name}: {skipped}")

    def _skipped(self) -> str:
        """Run and judge the method; return why the item is to be skipped, empty if it passes.

        Raises
        ------
        Disagreement
            If the method fails the test, as `runtest` describes.
        """
        scenario, prepared = self.parent.scenario, self.parent.prepared
        study = convergence_study_of(scenario, self.engine, self.method, prepared)
        verdict = run_and_judge(study, _worker(self.config))
        is_open = verdict.verdict == "unresolved" and verdict.is_unproven
        if not verdict.agrees or is_open:
            raise Disagreement(
                *verdict.findings,
                f"reproduce with: spincheck run {self.typed} "
                f"--engine {self.engine.name} --method {self.method.name}",
                *(self._remedies() if verdict.findings[0] in verdict.unmet else ()),
            )
        if verdict.verdict != "converges" and not (verdict.as_shipped or verdict.expected_failure):
            return f"{verdict.verdict}: {verdict.reason}"
        return ""

    def _remedies(self) -> Iterator[str]:
        """Yield commands that find a timestep at which errors are within the expected bounds."""
        own = (self.engine.name, self.method.name)
        for expect in self.parent.scenario.expect:
            if expect.bounds() and (expect.engine, expect.method) == own:
                bounds = (f"{option(name)} {bound:g}" for name, bound in expect.bounds().items())
                words = ["spincheck recommend", self.typed, "--engine", own[0], *bounds]
                yield f"a method and timestep that keep it: {' '.join(words)}"


class MissingEngineItem(SceneItem):
    """An item that is skipped because an engine is missing; the message says why it is missing."""

    def __init__(self, *, reason: str, **parent_and_name: Any) -> None:
        super().__init__(**parent_and_name)
        self.reason = reason

    def runtest(self) -> None:
        """Skip the item."""
        pytest.skip(f"not tested: {self.reason}")


_WORKER = pytest.StashKey[LocalWorkers]()


def _worker(config: pytest.Config) -> LocalWorkers:
    """Return the worker process of pytest's session; an engine that crashes it fails one item only.

    The worker is started at the first call.
    """
    if _WORKER not in config.stash:
        config.stash[_WORKER] = LocalWorkers(jobs=1)
        config.add_cleanup(config.stash[_WORKER].close)
    return config.stash[_WORKER]
