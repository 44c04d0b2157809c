"""Which engines turn a free body as if there were no gyroscopic torque, seen in their motions.

Without ω × I ω nothing turns the angular velocity of a body that no torque acts on: it keeps its
direction in space, however the body tumbles. A damping shortens ω and turns it as little.
"""

from dataclasses import dataclass

import numpy as np

from ....scenarios import Trajectory
from ...results.records import Pair
from .report_data import Compared, ReportData

#: rad; a scene tells if its exact ω turns by more, in space.
TELLING = 0.2
#: A run whose ω turns by less than this part of it lacks the torque.
STEADY = 0.02


@dataclass(frozen=True)
class NoGyroscopicTorque:
    """An engine as shipped whose ω keeps its direction in space where it should not.

    Attributes
    ----------
    scenes : names of those where that is seen
    worst_scene, omega_error : where ω is furthest off, relative, and by how much
    """

    engine: str
    scenes: tuple[str, ...]
    worst_scene: str
    omega_error: float


def without_gyroscopic_torque(
    gathered: ReportData,
) -> tuple[tuple[NoGyroscopicTorque, ...], int]:
    """The engines as shipped that lack it on every scene that tells, and of how many engines."""
    lacking: dict[Pair, dict[str, float]] = {}
    has_it: set[Pair] = set()
    for scene in gathered.scenes:
        if scene.solved is None or scene.solved.scenario.called_for - {"gravity"}:
            continue
        for run in scene.compared:
            pair = (run.runs.engine, run.runs.method)
            shipped = run.runs.declared is not None and run.runs.declared.as_shipped
            if not shipped or turned_in_space(run.exact) < TELLING:
                continue
            if _is_steady(run):
                lacking.setdefault(pair, {})[scene.name] = float(run.series.omega.max())
            else:
                has_it.add(pair)
    engines = {engine for engine, _ in {*lacking, *has_it}}
    first = {pair[0]: errors for pair, errors in lacking.items() if pair not in has_it}
    findings = tuple(_of_engine(engine, errors) for engine, errors in sorted(first.items()))
    return findings, len(engines)


def turned_in_space(motion: Trajectory) -> float:
    """The largest angle between ω and what it was at the start, rad; 0 of a body at rest."""
    omega_world = motion.to_world(motion.omega_body)
    start = omega_world[0]
    across = np.linalg.norm(np.cross(omega_world, start), axis=1)
    return float(np.arctan2(across, omega_world @ start).max())


def _is_steady(run: Compared) -> bool:
    return turned_in_space(run.motion) < STEADY * turned_in_space(run.exact)


def _of_engine(engine: str, errors: dict[str, float]) -> NoGyroscopicTorque:
    worst = max(errors, key=lambda name: errors[name])
    return NoGyroscopicTorque(engine, tuple(errors), worst, errors[worst])
