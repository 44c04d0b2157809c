"""Each planted fault of an engine's motion is detected by the test of the suite made for it."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from planted_physics import Damped, Ungyroscopic
from spincheck.engines import State
from spincheck.reports.cli.suite.hooks import EngineSubject
from spincheck.suite import test_physics
from stepped import DRAG, GRAVITY, METHODS, PUSH_BODY, PUSH_WORLD, Stepped, SteppedEngine

pytestmark = pytest.mark.slow

TESTS = {name: test for name, test in vars(test_physics).items() if name.startswith("test_")}


class Other(Stepped):
    """A session whose constants are others."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.constants = self.constants_with(self.held())
        self.change()

    def held(self) -> np.ndarray:
        return self.inertia

    def change(self) -> None:
        """Change the constants."""


class StartsAtRestAboutTheMinorAxes(Stepped):
    """What is small at the start is rounded off."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        small = np.abs(self.omega) < 0.05 * np.abs(self.omega).max()
        self.dropped = np.where(small, self.omega, 0.0)

    def advance(self, steps: int) -> None:
        if not self.taken:
            self.omega[:] -= self.dropped
        super().advance(steps)


class DiagonalInertia(Other):
    def held(self) -> np.ndarray:
        return np.diag(np.diag(self.inertia))


class Leaks(Other):
    """Turned by a torque in space that nobody called for."""

    def change(self) -> None:
        self.constants[PUSH_WORLD] += 1e-3 * self.unit_torque


class HalvesTheTurn(Stepped):
    """The attitude's rate lacks its factor ½ twice."""

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            before = self.y[:4].copy()
            self.take(1)
            middle = before + self.y[:4]
            self.y[:4] = middle / np.linalg.norm(middle)


class ClampedAt100(Stepped):
    def after_step(self) -> None:
        self.omega[:] = np.clip(self.omega, -100.0, 100.0)


class FallsAsleep(Stepped):
    """After two seconds at less than 0.1 rad/s."""

    slow_for = 0.0

    def after_step(self) -> None:
        is_slow = float(np.linalg.norm(self.omega)) < 0.1
        self.slow_for = self.slow_for + self.timestep if is_slow else 0.0
        if self.slow_for > 2.0:
            self.omega[:] = 0.0


class DragWithoutInertia(Other):
    """ω̇ = −c ω, whatever the inertia."""

    def change(self) -> None:
        self.constants[DRAG] *= self.inertia[0, 0]


class BodyTorqueInWorldAxes(Other):
    def change(self) -> None:
        self.constants[PUSH_WORLD], self.constants[PUSH_BODY] = self.constants[PUSH_BODY], 0.0


class WorldTorqueInBodyAxes(Other):
    def change(self) -> None:
        self.constants[PUSH_BODY], self.constants[PUSH_WORLD] = self.constants[PUSH_WORLD], 0.0


class TurnsAboutItsOrigin(Stepped):
    """What flies straight is the origin."""

    def reading(self, state: State) -> State:
        if self.scenario.has_pivot:
            return state
        com, start = np.array(self.scenario.body.com), self.scenario.start.q_world_body_wxyz
        turn, first = _turned(self.y[:4], com), _turned(start, com)
        omega_world = _turned(self.y[:4], self.omega)
        return replace(
            state,
            com_world=state.com_world + turn - first,
            velocity_world=state.velocity_world + np.cross(omega_world, turn),
        )


def _turned(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    w, v = q[0], q[1:]
    return vector + 2 * w * np.cross(v, vector) + 2 * np.cross(v, np.cross(v, vector))


class RubsOnItsPivot(Other):
    def change(self) -> None:
        if self.scenario.has_pivot:
            self.constants[DRAG] += 1e-3 * self.inertia[0, 0]


class Lighter(Other):
    def change(self) -> None:
        self.constants[GRAVITY] *= 0.99


class Regularised(Other):
    """A fixed number is added to the moments."""

    def held(self) -> np.ndarray:
        return self.inertia + 1e-10 * np.eye(3)


FAULTS: dict[str, type[Stepped]] = {
    "test_free_asymmetric_gyroscopic_torque": Ungyroscopic,
    "test_flip_about_the_middle_axis": StartsAtRestAboutTheMinorAxes,
    "test_off_diagonal_inertia": DiagonalInertia,
    "test_angular_momentum_is_conserved": Leaks,
    "test_energy_is_conserved": Leaks,
    "test_attitude_follows_omega": HalvesTheTurn,
    "test_no_hidden_damping": Damped,
    "test_no_velocity_clamp": ClampedAt100,
    "test_slow_rotation_goes_on": FallsAsleep,
    "test_drag_is_a_torque": DragWithoutInertia,
    "test_torque_in_body_axes": BodyTorqueInWorldAxes,
    "test_torque_in_world_axes": WorldTorqueInBodyAxes,
    "test_offset_com": TurnsAboutItsOrigin,
    "test_frictionless_pivot": RubsOnItsPivot,
    "test_heavy_top": Lighter,
    "test_small_body": Regularised,
}


@each_case("name", sorted({*TESTS, *FAULTS}))
def test_a_faultless_engine_passes_and_a_planted_fault_is_detected(name: str) -> None:
    passed(TESTS[name], Stepped)
    with pytest.raises(pytest.fail.Exception, match=r"it (disagrees|diverges|failed)"):
        passed(TESTS[name], FAULTS[name])


@cache
def subject(kind: type[Stepped]) -> EngineSubject:
    """One for all tests, which keeps its verdicts: some tests are on the same scene."""
    return EngineSubject(SteppedEngine(kind, 0.0), METHODS[2])


def passed(test: Callable[[Any], None], kind: type[Stepped]) -> None:
    """Run a test; one that is skipped has decided nothing."""
    try:
        test(subject(kind))
    except pytest.skip.Exception as reason:
        raise AssertionError(f"undecided: {reason}") from None
