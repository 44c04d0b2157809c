"""Determines which results of a study are in the result file, and which must be computed."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ...scenarios import Scenario
from ..results.environment import processor
from ..results.fingerprints import fingerprints
from ..results.records import Key
from ..results.store import Store
from ..results.verdicts import Verdict
from .choice import Choice, EngineMethod
from .executors import may_succeed_if_repeated


@dataclass(frozen=True, eq=False)
class SceneLeft:
    """A scene for which results are missing.

    Attributes
    ----------
    to_run : the methods without a verdict, with their engines
    to_time : whether the steps of at least one method must still be timed
    """

    scenario: Scenario
    to_run: list[EngineMethod]
    to_time: bool


@dataclass(frozen=True, eq=False)
class Plan:
    """The results of a study that are still to be computed.

    Attributes
    ----------
    scenes : the scenes for which results are missing, in the order asked for
    there : number of valid verdicts in the result file
    outdated : number of verdicts that are invalid because scene, engine or program has changed
    """

    scenes: list[SceneLeft]
    there: int
    outdated: int

    @property
    def total(self) -> int:
        """Number of missing verdicts, plus the number of scenes that must be timed."""
        return sum(len(scene.to_run) + scene.to_time for scene in self.scenes)

    def __str__(self) -> str:
        """Return in words how many verdicts are stored or outdated; an empty text if none are."""
        verdicts = self.there + sum(len(scene.to_run) for scene in self.scenes)
        counts = [f"{self.there} of {verdicts} verdicts are stored already"] if self.there else []
        if self.outdated:
            counts.append(f"{self.outdated} do not count: scene, engine or spincheck changed since")
        return "; ".join(counts)


def plan(scenarios: Sequence[Scenario], choice: Choice, store: Store) -> Plan:
    """Return the results of a study of some scenes that are missing from the result file.

    Outdated results count as missing. Costs that were measured on another processor are deleted
    from the file. If `Choice.again` is set, the stored results that the choice asks for are deleted
    first.
    """
    if choice.again:
        store.forget(key for scenario in scenarios for key in choice.methods_on(scenario))
    outdated = sum(store.rest_on(tuple(fingerprints(s, choice.engines))) for s in scenarios)
    settled = {
        verdict.key: verdict
        for scenario in scenarios
        for verdict in settled_verdicts(scenario, choice, store)
    }
    store.forget_costs_of_other_processors(processor())
    timed = store.keys_with_timing()
    scenes = [
        SceneLeft(
            scenario,
            [pair for key, pair in choice.methods_on(scenario).items() if key not in settled],
            choice.times(scenario) and _has_untimed(scenario, choice, settled, timed),
        )
        for scenario in scenarios
    ]
    missing = sum(len(scene.to_run) for scene in scenes)
    there = sum(len(choice.methods_on(scenario)) for scenario in scenarios) - missing
    return Plan([scene for scene in scenes if scene.to_run or scene.to_time], there, outdated)


def settled_verdicts(scenario: Scenario, choice: Choice, store: Store) -> list[Verdict]:
    """Return the stored verdicts on a scene, for `choice.timesteps`, that need not be made again.

    A method's verdict is left out if one of its failed runs, or its examination, may succeed when
    it is made again (`may_succeed_if_repeated`), or if its ladder ended at a lower step limit than
    the present one.
    """
    failures = [(row.key, row.cause, row.reason) for row in store.failed_rows(scenario.name)]
    failures += [(e.key, e.cause, e.refusal) for e in store.refused_evidence(scenario.name)]
    to_repeat = {
        key
        for key, cause, reason in failures
        if may_succeed_if_repeated(cause, reason, choice.time_limit)
    }
    verdicts = store.settled(scenario.name, choice.timesteps, choice.max_steps_on(scenario))
    return [verdict for verdict in verdicts if verdict.key not in to_repeat]


def _has_untimed(
    scenario: Scenario, choice: Choice, settled: Mapping[Key, Verdict], timed: Collection[Key]
) -> bool:
    """Whether the cost of any method whose steps can be timed is missing.

    Parameters
    ----------
    settled : stored verdicts, by key
    timed : keys of the methods with a stored cost
    """
    return any(
        can_be_timed(scenario, pair, settled.get(key))
        for key, pair in choice.methods_on(scenario).items()
        if key not in timed
    )


def can_be_timed(scenario: Scenario, pair: EngineMethod, verdict: Verdict | None) -> bool:
    """Whether the steps of a method on a scene can be timed, as far as that is known.

    They cannot if the verdict is `failed` or `unsupported`, or if the engine does not support the
    scene. A method that differs from another only in how it reads models is not timed, as both take
    the same steps.

    Parameters
    ----------
    pair : the engine and the method
    verdict : the stored verdict; None if there is none
    """
    engine, method = pair
    failed = verdict is not None and verdict.verdict in ("failed", "unsupported")
    return not (failed or method.reader or engine.unsupported(scenario, method))
