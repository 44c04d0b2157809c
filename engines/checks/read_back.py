"""Compares body and start as read back from an engine with the scene's, before the first step."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import conjugate, cross, matrix, norms, rotation_vectors
from ..fault import Cause

#: Relative tolerance of a model or state that is read back. Text with 17 digits and a few products
#: of rotations lose some ulp; a dropped frame or a default value is far larger.
READ_BACK_SLACK = 1e-12
#: The same for engines in single precision.
READ_BACK_SLACK_SINGLE = 1e-5
#: Of a tensor about the origin, which an engine may hold: of 4 500 ulp by which a number in double
#: precision may be off, 4.
OF_ORIGIN = 2.0**-10


class EngineError(Exception):
    """The engine warned, reset or clamped the state, or read back another body or start.

    Parameters
    ----------
    reason : in words
    cause : in a word, if the engine or its adapter knows one
    """

    def __init__(self, reason: str, cause: Cause = "") -> None:
        super().__init__(reason)
        self.cause: Cause = cause


class UnsupportedError(EngineError):
    """The engine is known to simulate this body wrongly without an error: the run is not made."""

    def __init__(self, reason: str, cause: Cause = "body") -> None:
        super().__init__(reason, cause)


@dataclass(frozen=True, eq=False)
class BodyReading:
    """A body as the engine holds it: kg; m from the body's origin; kg m² about the com; body axes.

    `com` is (3,), `inertia_com` is (3, 3). Of rotors, which are in it as if they did not turn,
    `axial` is what a spin adds to L: axis times moment about it, kg m², (rotors, 3).
    """

    mass: float
    com: FloatArray
    inertia_com: FloatArray
    axial: FloatArray = field(default_factory=lambda: np.empty((0, 3)))

    def placed(self, at: FloatArray, R: FloatArray) -> "BodyReading":
        """The same body in other axes: its origin is at `at` (3,) m there, turned by R (3, 3)."""
        return BodyReading(
            self.mass, at + R @ self.com, R @ self.inertia_com @ R.T, self.axial @ R.T
        )


def composed(parts: Sequence[BodyReading]) -> BodyReading:
    """Parts in the same axes as one rigid body (parallel-axis theorem)."""
    mass = sum(part.mass for part in parts)
    com = sum((part.mass * part.com for part in parts), np.zeros(3)) / (mass or 1.0)
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.com - com
        tensor += part.inertia_com + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return BodyReading(mass, com, tensor)


@dataclass(frozen=True, eq=False)
class State:
    """What is read at a sample: attitude (4,), ω (3,) rad/s, com (3,) m, its velocity (3,) m/s.

    Of rotors also their spins relative to the body, (rotors,) rad/s. For n samples, one a row:
    (n, 4) and (n, 3).
    """

    q_world_body_wxyz: FloatArray
    omega_body: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray
    spins: FloatArray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        shape = (*self.omega_body.shape[:-1], 0)
        if not self.spins.size and self.spins.shape != shape:
            object.__setattr__(self, "spins", np.empty(shape))

    @property
    def columns(self) -> list[FloatArray]:
        """The arrays of the state, one for each quantity."""
        return list(vars(self).values())

    def rows(self, kept: int | slice | NDArray[np.bool_] | NDArray[np.intp]) -> "State":
        """One of n states by its index, or several by a slice, a mask (n,) or indices."""
        return State(
            self.q_world_body_wxyz[kept],
            self.omega_body[kept],
            self.com_world[kept],
            self.velocity_world[kept],
            self.spins[kept],
        )


def stacked(states: Sequence[State]) -> State:
    """States as the rows of one state, in the order given."""
    return State(*map(np.vstack, zip(*(state.columns for state in states), strict=True)))


@dataclass(frozen=True, eq=False)
class Difference:
    """A quantity whose value in an engine differs from the scene's.

    Attributes
    ----------
    wanted, got : the scene's value and the engine's
    relative : their largest difference, relative to the size of the quantity
    why : the usual mistake that explains it, in words, if one does
    """

    what: str
    wanted: FloatArray
    got: FloatArray
    relative: float
    why: str = ""

    @property
    def complaint(self) -> str:
        """The message of a run that fails because of it, with all digits."""
        wanted, got = self.wanted.tolist(), self.got.tolist()
        why = f": {self.why}" if self.why else ""
        return f"'{self.what}' must read back as {wanted}, got {got}{why}"

    @property
    def remark(self) -> str:
        """The message of a run that goes on in spite of it, rounded."""
        wanted, got = _rounded(self.wanted), _rounded(self.got)
        return f"'{self.what}' reads back as {got}, not {wanted}: off by {self.relative:.1%}"


def differences(
    scenario: Scenario, reading: BodyReading, state: State, slack: float
) -> list[Difference]:
    """Compare a freshly loaded model and state with the scene.

    Parameters
    ----------
    slack : allowed difference, relative to the size of each quantity
    """
    differing = []
    steiner = OF_ORIGIN * scenario.body.mass * float(scenario.body.com @ scenario.body.com)
    for what, got, wanted, size in _pairs(scenario, reading, state):
        largest = float(np.abs(np.subtract(got, wanted)).max())
        if not largest <= slack * (size + (steiner if what == "inertia_com" else 0.0)):
            relative = largest / size if size else np.inf
            why = _turned(scenario, got, slack * size) if what == "omega_body" else ""
            differing.append(Difference(what, wanted, got, relative, why))
    wanted_q, got_q = scenario.start.q_world_body_wxyz, state.q_world_body_wxyz
    angle = float(norms(rotation_vectors(got_q[None], wanted_q[None]))[0])
    if not angle <= slack:
        words = _misread(wanted_q, got_q, slack)
        off = Difference("q_world_body_wxyz", wanted_q, got_q, angle, words)
        # Where it is known why, ω in body axes is off for the same reason.
        differing.insert(0 if words else len(differing), off)
    return differing


def _misread(wanted_q: FloatArray, got_q: FloatArray, slack: float) -> str:
    """The usual mistake that makes one quaternion of the other, in words; empty if none does."""
    conjugated = conjugate(wanted_q)
    order, inverse = "its components are permuted, w x y z for x y z w", "it is conjugated"
    mistakes = (
        (np.roll(wanted_q, -1), order),
        (np.roll(wanted_q, 1), order),
        (conjugated, f"{inverse}, world to body instead of body to world"),
        (np.roll(conjugated, -1), f"{order}, and {inverse}"),
        (np.roll(conjugated, 1), f"{order}, and {inverse}"),
    )
    for mistaken, words in mistakes:
        if float(norms(rotation_vectors(got_q[None], mistaken[None]))[0]) <= slack:
            return words
    return ""


def _turned(scenario: Scenario, got: FloatArray, slack: float) -> str:
    """The words that ω is right in other axes than it was asked for; empty if it is not."""
    R_world_body, omega_body = matrix(scenario.start.q_world_body_wxyz), scenario.start.omega_body
    for turned in (R_world_body @ omega_body, omega_body @ R_world_body):
        if np.abs(got - turned).max() <= slack:
            return "its components are along the other axes, the world's for the body's or reverse"
    return ""


def start_state(scenario: Scenario) -> State:
    """The scene's start; of a body on a pivot, com and its velocity follow from attitude and ω."""
    start = scenario.start
    R_world_body, constraint = matrix(start.q_world_body_wxyz), scenario.constraint
    swing_world = R_world_body @ cross(start.omega_body, constraint.lever)
    return State(
        start.q_world_body_wxyz,
        start.omega_body,
        constraint.com_world(R_world_body @ constraint.lever, start.position_world),
        constraint.velocity_world(swing_world, start.velocity_world),
        scenario.rotors.start_spins,
    )


def _pairs(
    scenario: Scenario, reading: BodyReading, state: State
) -> Iterator[tuple[str, FloatArray, FloatArray, float]]:
    """Name, value got, value wanted, and the size its difference is measured against."""
    body, start = scenario.body, start_state(scenario)
    arm = float(np.linalg.norm(body.com))
    speed = float(np.linalg.norm(start.omega_body))
    # Not of the tensor about the origin: with a long arm that would hide faults of this one.
    sizes = {"mass": body.mass, "com": arm, "inertia_com": float(body.principal_moments[-1])}
    for what, got, wanted in body_pairs(scenario, reading):
        yield what, got, wanted, sizes.get(what, float(np.linalg.norm(wanted)))
    for rotor in range(len(scenario.rotors.each)):
        spin = scenario.rotors.start_spins[rotor : rotor + 1]
        size = float(np.abs(spin).max()) + speed
        yield f"spin of rotor {rotor + 1}", state.spins[rotor : rotor + 1], spin, size
    yield "omega_body", state.omega_body, start.omega_body, speed
    size = arm + float(np.linalg.norm(start.com_world))
    yield "com_world", state.com_world, start.com_world, size
    size = arm * speed + float(np.linalg.norm(start.velocity_world))
    yield "velocity_world", state.velocity_world, start.velocity_world, size


def body_pairs(
    scenario: Scenario, reading: BodyReading
) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """Name, value got and value wanted of each number of the body."""
    body = scenario.body
    yield "mass", np.array(reading.mass), np.array(body.mass)
    yield "com", reading.com, body.com
    yield "inertia_com", reading.inertia_com, body.inertia_com
    for number, axial in enumerate(scenario.rotors.axial_body, start=1):
        yield f"axial moment of rotor {number}", reading.axial[number - 1], axial


def _rounded(values: FloatArray) -> str:
    """A number or nested lists of numbers, to three digits, with round-off set to zero."""
    least = float(np.finfo(float).eps) * np.abs(values).max()
    shown = np.where(np.abs(values) > least, values, 0.0)
    written = np.array2string(shown, separator=", ", formatter={"float_kind": "{:.3g}".format})
    return written.replace("\n", "")
