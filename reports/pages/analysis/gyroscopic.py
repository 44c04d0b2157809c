"""Detects, from their motions, engines that lack the gyroscopic torque.

Without ω × I ω the angular velocity of a free body keeps its direction in space, however the body
tumbles. A damping shortens ω but does not turn it either.
"""

from dataclasses import dataclass

import numpy as np

from ....scenarios import Trajectory
from ...results.records import Pair
from .report_data import Compared, ReportData

#: rad; a scene is used if its exact ω turns by more in space.
TELLING = 0.2
#: A run lacks the torque if its ω turns by less than this fraction of that.
STEADY = 0.02


@dataclass(frozen=True)
class NoGyroscopicTorque:
    """An engine as shipped whose ω keeps its direction in space though the exact ω does not.

    Attributes
    ----------
    scenes : names of the scenes where that is so
    worst_scene, omega_error : the scene with the largest relative error of ω, and that error
    """

    engine: str
    scenes: tuple[str, ...]
    worst_scene: str
    omega_error: float


def without_gyroscopic_torque(
    gathered: ReportData,
) -> tuple[tuple[NoGyroscopicTorque, ...], int]:
    """The engines as shipped that lack it on every scene used, and the number of engines."""
    lacking: dict[Pair, dict[str, float]] = {}
    has_it: set[Pair] = set()
    for scene in gathered.scenes:
        if scene.solved is None or scene.solved.scenario.called_for - {"gravity"}:
            continue
        for run in scene.compared:
            shipped = run.runs.declared is not None and run.runs.declared.as_shipped
            if not shipped or turned_in_space(run.exact) < TELLING:
                continue
            if _is_steady(run):
                lacking.setdefault(run.runs.pair, {})[scene.name] = float(run.series["omega"].max())
            else:
                has_it.add(run.runs.pair)
    engines = {engine for engine, _ in {*lacking, *has_it}}
    first = {pair[0]: errors for pair, errors in lacking.items() if pair not in has_it}
    findings = tuple(_of_engine(engine, errors) for engine, errors in sorted(first.items()))
    return findings, len(engines)


def turned_in_space(motion: Trajectory) -> float:
    """The largest angle between ω and ω at the start, in space, rad; 0 for a body at rest."""
    omega_world = motion.to_world(motion.omega_body)
    start = omega_world[0]
    across = np.linalg.norm(np.cross(omega_world, start), axis=1)
    return float(np.arctan2(across, omega_world @ start).max())


def _is_steady(run: Compared) -> bool:
    return turned_in_space(run.motion) < STEADY * turned_in_space(run.exact)


def _of_engine(engine: str, errors: dict[str, float]) -> NoGyroscopicTorque:
    worst = max(errors, key=lambda name: errors[name])
    return NoGyroscopicTorque(engine, tuple(errors), worst, errors[worst])
