"""Finds the one change of a scene's equations of motion that explains what an engine's steps gain.

To first order a change of the model by θ adds B θ to what the states gain, B known from the scene.
θ is fitted to the gains from several starts at once, by least squares; a change explains them if
nothing but noise is left. Of several explanations, the one with the fewest numbers is reported.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ....engines import State
from ....engines.checks.equations import Equations
from ....scenarios import FloatArray
from ....scenarios.rotation import cross, matrix, rotation_vectors
from ...results.evidence import ChangeKind, Explanation
from .noise import NO_SIZE
from .steps import flowed

#: Fraction that may be left unexplained: the fit is linear in θ, the model need not be.
LINEAR, LINEAR_AT_MOST = 1e-2, 0.2
#: A change of a factor this close to ±1, … is taken for it, as is one within its uncertainty.
WHOLE = 1e-2
#: A number with a smaller effect than this, relative to the others, is ignored.
RANK = 1e-6
#: Two changes are distinguished if what they leave unexplained differs by this factor.
ALIKE = 4.0


@dataclass(frozen=True, eq=False)
class Gain:
    """The gain of a state per second in excess of the exact gain, and its scale.

    Attributes
    ----------
    before, middle : the state, and the exact one half of the span later
    excess, wanted : of the four quantities of `step_gains`, and the exact gains, (4, 3)
    """

    before: State
    middle: State
    excess: FloatArray
    wanted: FloatArray


def gains_of(
    equations: Equations, before: State, exact: State, spans: FloatArray, excess: FloatArray
) -> list[Gain]:
    """The exact gains of K states, beside what is gained in excess, (K, 4, 3).

    Parameters
    ----------
    exact : the states a time `spans` later, s, (K,)
    """
    scenario = equations.scenario
    middles = flowed(scenario, before, spans / 2)
    turns = rotation_vectors(before.q_world_body_wxyz, exact.q_world_body_wxyz)
    gains: list[Gain] = []
    for k, beyond in enumerate(excess):
        start, end, span = before.rows(k), exact.rows(k), float(spans[k])
        torque = equations.inertia @ (end.omega_body - start.omega_body) / span
        if scenario.constraint.is_pivot:
            R, com = matrix(end.q_world_body_wxyz), np.array(scenario.body.com)
            velocity, place = R @ cross(end.omega_body, com), R @ com
        else:
            velocity = (end.velocity_world - start.velocity_world) / span
            if scenario.constraint.is_free:
                velocity = scenario.gravity_world
            place = (end.com_world - start.com_world) / span
        wanted = np.array([turns[k] / span, torque, velocity, place])
        gains.append(Gain(start, middles.rows(k), beyond, wanted))
    return gains


@dataclass(frozen=True, eq=False)
class _Change:
    """A change of the model.

    Attributes
    ----------
    effects : what each of its m numbers adds to the gains from n starts, (n, 4, 3, m)
    base : what the numbers are changes of, (m,)
    is_factor : whether its numbers are changes of a factor, which are taken for whole ones nearby
    is_whole : whether only the change by one counts, that leaves a term out
    """

    kind: ChangeKind
    effects: FloatArray
    base: FloatArray | float = 0.0
    is_factor: bool = False
    is_whole: bool = False

    def of(self, theta: FloatArray) -> Explanation | None:
        """As an explanation; None if the numbers are impossible, or no change."""
        if self.is_factor and (theta[0] == 0 or (self.is_whole and theta[0] != 1)):
            return None
        numbers = self.base + theta
        if self.kind == "moments" and not (numbers > 0).all():
            return None
        return Explanation(self.kind, tuple(map(float, numbers)))


def explanation(
    equations: Equations, gains: Sequence[Gain], noise: FloatArray
) -> Explanation | None:
    """The change of the model that explains the gains; None if no single one does.

    Parameters
    ----------
    noise : the largest that it makes of the gains' excess, (n, 4)
    """
    excess = np.array([gain.excess for gain in gains])
    weights = 1 / np.maximum(noise, NO_SIZE)[..., None]
    seen = (weights * excess).ravel()
    size = float(np.linalg.norm(excess / np.maximum(_sizes(gains), NO_SIZE)))
    slack = np.abs(seen).max() * min(max(LINEAR, size), LINEAR_AT_MOST)
    candidates = []
    for change in _changes(equations, gains):
        matrix = (weights[..., None] * change.effects).reshape(len(seen), -1)
        # Numbers without an effect, such as the scale of a free body's tensor, are not changed.
        theta, _, count, _ = np.linalg.lstsq(matrix, seen, rcond=RANK)
        rest = float(np.abs(seen - matrix @ theta).max())
        # What the noise, or what is left, may make of the numbers.
        unsure = max(1.0, rest) * np.linalg.norm(np.linalg.pinv(matrix, RANK), axis=1)
        if not (np.abs(theta) > unsure).any():
            continue
        if change.is_factor:
            whole = np.round(theta)
            near = np.maximum(WHOLE * (whole != 0), unsure)
            theta = np.where(np.abs(theta - whole) <= near, whole, theta)
        if rest <= max(1.0, slack) and (found := change.of(theta)):
            candidates.append((count, rest, found))
    fewest = min((count for count, _, _ in candidates), default=0)
    alike = [(rest, found) for count, rest, found in candidates if count == fewest]
    # Some changes are equivalent; the first of them is reported.
    best = min((rest for rest, _ in alike), default=0.0)
    return next((found for rest, found in alike if rest <= max(1.0, ALIKE * best)), None)


def _sizes(gains: Sequence[Gain]) -> FloatArray:
    """Sizes of the exact gains, (n, 4, 1)."""
    return np.array([np.linalg.norm(gain.wanted, axis=1) for gain in gains])[..., None]


def _changes(equations: Equations, gains: Sequence[Gain]) -> Iterator[_Change]:
    starts = [_Start(equations, gain) for gain in gains]
    scenario = equations.scenario

    def effect(*columns: Callable[["_Start"], FloatArray]) -> FloatArray:
        return np.stack([[column(start) for start in starts] for column in columns], axis=-1)

    # Of a body held by a constraint what is due to spin about the com may be left out alone.
    com = scenario.body.inertia_com
    of_com = effect(lambda s: s.torque(cross(s.omega, com @ s.omega)))
    yield _Change("gyroscopic", of_com, is_factor=True, is_whole=True)
    yield _Change("gyroscopic", effect(lambda s: s.torque(s.gyroscopic)), is_factor=True)
    pull, axes = scenario.gravity_world, np.eye(3)
    if pull.any():
        yield _Change("gravity's size", effect(lambda s: s.gravity(pull)), is_factor=True)
        along = effect(*(lambda s, axis=axis: s.gravity(axis) for axis in axes))
        yield _Change("gravity", along, pull)
    yield _Change("resistance", effect(lambda s: s.torque(-s.omega)))
    slowing = lambda s: s.torque(-s.L)  # noqa: E731
    yield _Change("decay", effect(slowing))
    faster = lambda s: s.torque(-s.L * np.linalg.norm(s.omega))  # noqa: E731
    yield _Change("decays", effect(slowing, faster))
    if any(one.wrong_momentum for one in scenario.acting):
        yield _Change("momentum", effect(lambda s: s.torque(-cross(s.omega, s.kept))))
    yield _Change("step", effect(lambda s: s.gain.wanted * s.is_rate))
    yield _Change("omega", effect(_Start.scaled_omega))
    yield _Change("velocity", effect(_Start.scaled_velocity))
    moments, principal = np.linalg.eigh(equations.inertia)
    tensors = [np.outer(axis, axis) for axis in principal.T]
    of_tensors = (lambda s, tensor=tensor: s.torque(s.of_tensor(tensor)) for tensor in tensors)
    yield _Change("moments", effect(*of_tensors), moments)
    if scenario.constraint.is_pivot:
        moved = effect(*(lambda s, axis=axis: s.moved(axis) for axis in axes))
        yield _Change("com", moved, np.array(scenario.body.com))


class _Start:
    """The contributions of changes of a model to a gain, each (4, 3)."""

    def __init__(self, equations: Equations, gain: Gain) -> None:
        self.equations, self.gain = equations, gain
        middle = gain.middle
        self.R = matrix(middle.q_world_body_wxyz)
        self.omega = middle.omega_body
        self.kept = equations.kept_body(middle)
        self.L = equations.inertia @ self.omega + self.kept
        self.gyroscopic = cross(self.omega, self.L)
        self.omega_rate = equations.inverse @ equations.torque_body(self.R, self.omega, self.kept)
        pivot = equations.scenario.constraint.is_pivot
        self.is_rate = np.array([1, 1, not pivot, not pivot], dtype=float)[:, None]

    def torque(self, torque_body: FloatArray) -> FloatArray:
        """The change of the gain by an additional torque."""
        return self._answered(torque_body, np.zeros(3))

    def _answered(self, torque_body: FloatArray, pull_world: FloatArray) -> FloatArray:
        """The change by a torque and an acceleration, and by what a constraint does about them."""
        scenario, up_body = self.equations.scenario, self.R[2]
        if scenario.answer is not None:
            added = up_body, np.zeros(3), torque_body, pull_world
            torque_body, pull_world = scenario.answer(scenario, *added)
        return np.array([np.zeros(3), torque_body, pull_world, np.zeros(3)])

    def of_tensor(self, tensor: FloatArray) -> FloatArray:
        """The torque that an additional tensor causes."""
        return -tensor @ self.omega_rate - cross(self.omega, tensor @ self.omega)

    def moved(self, axis: FloatArray) -> FloatArray:
        """The change of the gain of a body on a pivot by a com that is elsewhere."""
        body = self.equations.scenario.body
        com, mass = np.array(body.com), body.mass
        tensor = mass * (2 * (com @ axis) * np.eye(3) - np.outer(com, axis) - np.outer(axis, com))
        pull = mass * cross(axis, self.equations.scenario.gravity_world @ self.R)
        added = self.torque(pull + self.of_tensor(tensor))
        added[2], added[3] = self.R @ cross(self.omega, axis), self.R @ axis
        return added

    def gravity(self, gravity_world: FloatArray) -> FloatArray:
        """The change of the gain by additional gravity."""
        if not self.equations.scenario.constraint.is_pivot:
            return self._answered(np.zeros(3), gravity_world)
        body = self.equations.scenario.body
        return self.torque(body.mass * cross(body.com, gravity_world @ self.R))

    def scaled_omega(self) -> FloatArray:
        """The effect of a reading of ω too large: a larger gain, and the body turns less."""
        outer = self.equations.outer_body(self.R, np.zeros(3))
        added = self.torque(outer + self.gyroscopic)
        added[0] = -self.omega
        if self.equations.scenario.constraint.is_pivot:
            added[2] = -self.gain.wanted[2]
        return added

    def scaled_velocity(self) -> FloatArray:
        """The effect of a reading of the com's velocity that is too large."""
        added = np.zeros((4, 3))
        if self.equations.scenario.constraint.is_pivot:
            added[2] = self.gain.wanted[2]
        else:
            added[2], added[3] = self.gain.wanted[2], -self.gain.wanted[3]
        return added
