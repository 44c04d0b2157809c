"""What single steps of an engine show on a scene of the library."""

import stepped_faults as planted
from library_scenes import library_scene
from spincheck.engines import Engine
from spincheck.reports.harness.measuring.examine import examine
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.results.evidence import StepEvidence
from spincheck.reports.results.reasons import fault_in_words
from spincheck.scenarios import Scenario
from stepped import Stepped, SteppedEngine

#: Steps of a ladder, which is not run.
FEW = 1 << 8


def looked_at(
    engine: Engine, method: str, scene: str | Scenario, *, explains: bool = True
) -> StepEvidence:
    """The evidence of a method's steps on a scene, or on that one of the library."""
    scenario = library_scene(scene) if isinstance(scene, str) else scene
    at = prepare(scenario, (), FEW).places
    found = examine(engine, scenario, method, at, explains=explains)
    assert found is not None
    return found


def is_consistent(found: StepEvidence) -> bool:
    """Whether steps are known to be consistent with the equations of motion."""
    return found.fault is None and found.is_known


def in_words(found: StepEvidence) -> str:
    """How they are not; else empty."""
    return fault_in_words(found.fault) if found.fault else ""


def in_single(kind: type[Stepped] = Stepped, size: float = 0.0, **as_if: object) -> SteppedEngine:
    """An engine of that fault, with 24 bits."""
    return SteppedEngine(planted.in_single(kind), size, single_precision=True, **as_if)
