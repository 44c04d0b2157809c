"""The places of a sweep, where its points are: what is different there from the scene."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...scenarios import Scenario, Trajectory
from ...scenarios.fastest_rate import pace
from ...scenarios.scatter import member
from ...scenarios.vary import TIMESTEP, varied
from ..results.sweep_records import Ensemble, Map
from .ladder import Rung, single

#: Angle turned a step where no timestep is asked for, rad, at the start's pace.
STEP_TURN = 0.02


@dataclass(frozen=True)
class Place:
    """One scene and timestep.

    Attributes
    ----------
    at : as its points have it
    numbers : what is varied, by path, in the order of the axes; none for a member
    member : seed and number; None of a map
    timestep : s; None where it is chosen from the scene there
    """

    at: tuple[float, ...]
    numbers: tuple[tuple[str, float], ...] = ()
    member: tuple[int, int] | None = None
    timestep: float | None = None

    @property
    def known_by(self) -> str:
        """The same for the same scene and timestep, whichever sweep asks for it; JSON."""
        said: dict[str, float] = dict(self.numbers)
        if self.member is not None:
            said["seed"], said["member"] = self.member
        if self.timestep is not None:
            said[TIMESTEP] = self.timestep
        return json.dumps(said, sort_keys=True)

    def __str__(self) -> str:
        """In words."""
        said = [f"{path} {value:.6g}" for path, value in self.numbers]
        if self.member is not None:
            said.append(f"member {self.member[1]}")
        if self.timestep is not None:
            said.append(f"timestep {self.timestep:.6g}")
        return ", ".join(said)

    def scene(self, base: Scenario) -> Scenario:
        """The scene there.

        Raises
        ------
        ScenarioError
            If the numbers make none.
        """
        return member(base, *self.member) if self.member else varied(base, dict(self.numbers))

    def rung(self, scenario: Scenario) -> Rung:
        """Timestep and samples of a run of the scene there.

        Raises
        ------
        ValueError
            If the window is shorter than one step.
        """
        if self.timestep is not None:
            return single(self.timestep, scenario.times)
        intervals = scenario.window.samples - 1
        interval = scenario.window.duration / intervals
        a_step = max(1, int(np.ceil(interval * pace(scenario, _start(scenario)) / STEP_TURN)))
        return Rung(interval / a_step, np.arange(intervals + 1, dtype=np.int64) * a_step)


def places(asked: Map | Ensemble) -> Iterator[Place]:
    """All of them: of a map the second axis goes round within the first."""
    if isinstance(asked, Ensemble):
        for number in range(asked.members):
            yield Place((float(number),), (), (asked.seed, number), asked.timestep)
        return
    paths = [axis.path for axis in asked.axes]
    for at in product(*(axis.values for axis in asked.axes)):
        numbers = dict(zip(paths, at, strict=True))
        timestep = numbers.pop(TIMESTEP, asked.timestep)
        yield Place(at, tuple(numbers.items()), None, timestep)


def _start(scenario: Scenario) -> Trajectory:
    """The motion at t = 0, and no more of it."""
    start = scenario.start
    return Trajectory(
        t=np.zeros(1),
        q_world_body_wxyz=start.q_world_body_wxyz[np.newaxis],
        omega_body=start.omega_body[np.newaxis],
        com_world=start.position_world[np.newaxis],
        velocity_world=start.velocity_world[np.newaxis],
    )
