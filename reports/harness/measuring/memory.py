"""Whether a memory that vanishes with the timestep explains a run that differs from its replays."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....engines import Engine
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ...results.evidence import LEVEL, ReplayEvidence
from .examine import OPENED
from .gain_series import fitted
from .intervals import Replay
from .noise import NOISE, ULPS
from .places import Places
from .steps import Sessions, apart

#: Steps before and after a restart that show a memory.
REMEMBERED = 8
#: The factor by which a run may differ more than from exact states.
EXPLAINED = 3.0


def explained_by_memory(
    replays: Sequence[Replay],
    sessions: Sessions,
    engine: Engine,
    at: Places,
    declared: int,
    settled: int,
) -> list[ReplayEvidence]:
    """What replays show, where a memory that vanishes with the timestep may explain it.

    From exact states a method takes some steps at once, and others after it was restarted between
    them. What that changes, over the length of the one step that lacks its memory, is a gain like
    any other. It explains a run that differs from its replays by no more. Of a method whose steps
    are those of a settled constraint, impulses of earlier steps are in what these gain: they need
    explain no more than the size of the difference.

    Parameters
    ----------
    at : the exact states
    declared : the method's order
    settled : steps in which a constraint settled before those that were examined
    """
    equations, timesteps = Equations(sessions.scenario), at.timesteps
    remembered = max(REMEMBERED, settled)
    at_once, restarted = [], []
    if not sessions.first.can_restart:
        at = at.thinned(OPENED)
    for timestep in map(float, timesteps):
        for k in range(len(at.times)):
            with sessions.at(at.states.rows(k), timestep) as session:
                session.advance(remembered)
                middle = session.read_state()
                session.advance(remembered)
                at_once.append(session.read_state())
            with sessions.at(middle, timestep) as session:
                session.advance(remembered)
                restarted.append(session.read_state())
    off = apart(stacked(at_once), stacked(restarted), equations.reach)
    off = off.reshape(len(timesteps), -1, *off.shape[1:])
    sizes = np.abs(off).max(axis=(1, 2, 3))
    noise = max(NOISE, ULPS * engine.ulp) * np.sqrt(remembered)
    shown = [one.evidence for one in replays]
    tail, order = 1.0, 1
    if not settled:
        gains, table = off / timesteps[:, None, None, None], np.empty(off.shape[:2])
        table[:] = noise / timesteps[:, None]
        series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(off.shape[2])]
        tail = min(1.0, *(len(series) * one.tail for one in series))
        is_seen = np.abs(off).max(axis=(0, 1, 3)) > EXPLAINED * noise
        orders = [one.order for one, seen in zip(series, is_seen, strict=True) if seen]
        if tail < LEVEL or not orders:
            return shown
        order = min(orders)

    def explains(one: Replay) -> bool:
        size = float(np.interp(one.evidence.timestep, timesteps[::-1], sizes[::-1]))
        # What is left of an impulse goes on for as long as an interval lasts.
        lasting = max(1.0, one.steps / remembered) if settled else 1.0
        return one.off <= EXPLAINED * one.growth * lasting * size

    return [
        replace(one.evidence, tail=tail, order=order, declared=declared)
        if explains(one)
        else one.evidence
        for one in replays
    ]
