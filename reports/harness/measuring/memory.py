"""Whether a memory that vanishes with the timestep explains a run that differs from its replays."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....engines import Engine
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray
from ...results.evidence import LEVEL, ReplayEvidence
from .examine import OPENED
from .gain_series import fitted
from .intervals import Replay
from .noise import NOISE, SOLVED, ULPS
from .places import FINER, Places
from .steps import Sessions, apart

#: Steps before and after a restart that show a memory.
REMEMBERED = 8
#: The factor by which a run may differ more than from exact states: it is restarted twice in an
#: interval, and in more states than these.
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
    any other. It explains a run that differs from its replays by no more, after as many steps as
    its longest interval has. Where shorter timesteps show no memory, no more is explained than an
    iterative solver leaves, which begins with the step before. Of a method whose steps are those of
    a settled constraint, impulses of earlier steps are in what these gain: they need explain no
    more than the size of the difference.

    Parameters
    ----------
    at : the exact states
    declared : the method's order
    settled : steps in which a constraint settled before those that were examined
    """
    # With longer ones the body turns by many radians meanwhile; in 24 bits shorter ones show noise.
    timesteps = at.timesteps[0 if engine.single_precision else FINER :]
    remembered = max(REMEMBERED, settled)
    if not sessions.first.can_restart:
        at = at.thinned(OPENED)
    shown = [one.evidence for one in replays]
    tail, order = 1.0, 1
    if not settled:
        noise = max(NOISE, ULPS * engine.ulp) * np.sqrt(remembered)
        steps = remembered, remembered
        off = np.stack([_lacking(sessions, at, h, *steps) for h in map(float, timesteps)])
        gains, table = off / timesteps[:, None, None, None], np.empty(off.shape[:2])
        table[:] = noise / timesteps[:, None]
        series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(off.shape[2])]
        tail = min(1.0, *(len(series) * one.tail for one in series))
        is_seen = np.abs(off).max(axis=(0, 1, 3)) > EXPLAINED * noise
        orders = [one.order for one, seen in zip(series, is_seen, strict=True) if seen]
        if tail < LEVEL:
            return shown
        order = min(orders, default=0)

    def explains(one: Replay) -> bool:
        if not order and one.off > SOLVED:
            return False
        steps = remembered, max(remembered, one.steps)
        off = _lacking(sessions, at, one.evidence.timestep, *steps)
        # A run with a constraint is in states that no exact one is near, where changes grow more.
        growth = one.growth if settled else 1.0
        return one.off <= EXPLAINED * growth * float(np.sqrt((off**2).sum(axis=(1, 2))).max())

    return [
        replace(one.evidence, tail=tail, order=order or declared, declared=declared)
        if explains(one)
        else one.evidence
        for one in replays
    ]


def _lacking(
    sessions: Sessions, at: Places, timestep: float, before: int, after: int
) -> FloatArray:
    """What a restart between so many steps changes, as `apart` has it, (K, 5, 3).

    Few steps before it hold what a method remembers, and not what depends on a clock.
    """
    at_once, restarted = [], []
    for k in range(len(at.times)):
        with sessions.at(at.states.rows(k), timestep) as session:
            session.advance(before)
            middle = session.read_state()
            session.advance(after)
            at_once.append(session.read_state())
        with sessions.at(middle, timestep) as session:
            session.advance(after)
            restarted.append(session.read_state())
    reach = Equations(sessions.scenario).reach
    return apart(stacked(at_once), stacked(restarted), reach)
