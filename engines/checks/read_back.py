"""Compares body and start as read back from an engine with the scene's, before the first step."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import conjugate, cross, matrix, norms, rotation_vectors
from ..fault import Cause

#: Relative tolerance of a body or state that is read back. Text with 17 digits and a few products
#: of rotations lose some ulp; an ignored frame or a default value makes a far larger difference.
READ_BACK_SLACK = 1e-12
#: The same for engines in single precision.
READ_BACK_SLACK_SINGLE = 1e-5
#: Fraction of m |com|² that is added to a tensor's size, of which the relative tolerance is taken:
#: an engine may hold the tensor about the body's origin, where m |com|² is added, and rounds it
#: there. In double precision this allows 4 ulp of m |com|²: `READ_BACK_SLACK` is 4 500 ulp.
OF_ORIGIN = 2.0**-10


class EngineError(Exception):
    """An engine failed, refused a scene, warned, or reset or clamped the state.

    Parameters
    ----------
    reason : what happened, in a sentence
    cause : the cause, one of the words of `Cause`; empty if neither the engine nor its adapter
        knows it. Any other word is replaced by the empty one
    """

    def __init__(self, reason: str, cause: Cause = "") -> None:
        super().__init__(reason)
        self.cause: Cause = cause if cause in get_args(Cause) else ""


class UnsupportedError(EngineError):
    """The engine cannot do what is asked, or is known to do it wrongly without an error.

    The run is then refused, and not counted as failed.

    Parameters
    ----------
    reason : what is not supported, in a sentence
    cause : the cause, one of the words of `Cause`; by default the scene's body
    """

    def __init__(self, reason: str, cause: Cause = "body") -> None:
        super().__init__(reason, cause)


@dataclass(frozen=True, eq=False)
class BodyReading:
    """A body as read back from the engine, in the scene's body axes.

    Attributes
    ----------
    mass : mass of the body with its rotors, kg
    com : position of the com from the body's origin, m, (3,)
    inertia_com : tensor of inertia about the com, with rotors as fixed parts, kg m², (3, 3)
    axial : axis of each rotor, a unit vector, times the rotor's moment of inertia about it, kg m²,
        (rotors, 3): the derivative of the angular momentum by the spin
    """

    mass: float
    com: FloatArray
    inertia_com: FloatArray
    axial: FloatArray = field(default_factory=lambda: np.empty((0, 3)))

    def placed(self, at: FloatArray, R: FloatArray) -> "BodyReading":
        """Return the same body in the axes, and from the origin, of another frame.

        Parameters
        ----------
        at : position of the present origin in the other frame, m, (3,)
        R : the matrix that takes components along the present axes to components along the axes of
            the other frame, (3, 3)
        """
        return BodyReading(
            self.mass, at + R @ self.com, R @ self.inertia_com @ R.T, self.axial @ R.T
        )


def composed(parts: Sequence[BodyReading]) -> BodyReading:
    """Return the rigid body that several bodies form together (parallel-axis theorem).

    All are given in the same axes and from the same origin. The axial moments of rotors are left
    out.
    """
    mass = sum(part.mass for part in parts)
    com = sum((part.mass * part.com for part in parts), np.zeros(3)) / (mass or 1.0)
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.com - com
        tensor += part.inertia_com + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return BodyReading(mass, com, tensor)


@dataclass(frozen=True, eq=False)
class State:
    """The state of a body, or n states as the rows of each array.

    Attributes
    ----------
    q_world_body_wxyz : attitude, a quaternion w x y z, body to world, (4,) or (n, 4)
    omega_body : ω, rad/s, body axes, (3,) or (n, 3)
    com_world : position of the com, m, world axes, (3,) or (n, 3)
    velocity_world : velocity of the com, m/s, world axes, (3,) or (n, 3)
    spins : spins of the rotors, relative to the body, rad/s, (rotors,) or (n, rotors)
    """

    q_world_body_wxyz: FloatArray
    omega_body: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray
    spins: FloatArray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        # Lists in place of arrays pass here; `check_shapes` refuses them with a better message.
        shape = (*np.shape(self.omega_body)[:-1], 0)
        if not np.size(self.spins) and np.shape(self.spins) != shape:
            object.__setattr__(self, "spins", np.empty(shape))

    @property
    def columns(self) -> list[FloatArray]:
        """The arrays of the state: attitude, ω, position, velocity and spins."""
        return list(vars(self).values())

    def rows(self, kept: int | slice | NDArray[np.bool_] | NDArray[np.intp]) -> "State":
        """Return one of n states, chosen by its index, or several by a slice, mask or indices."""
        return State(
            self.q_world_body_wxyz[kept],
            self.omega_body[kept],
            self.com_world[kept],
            self.velocity_world[kept],
            self.spins[kept],
        )


def stacked(states: Sequence[State]) -> State:
    """Return several states as one state, whose arrays have a row for each in the order given."""
    return State(*map(np.vstack, zip(*(state.columns for state in states), strict=True)))


@dataclass(frozen=True, eq=False)
class Difference:
    """A quantity whose value in an engine differs from the scene's.

    Attributes
    ----------
    what : name of the quantity
    wanted, got : the scene's value and the engine's value
    relative : the largest difference of a component, relative to the size of the quantity; for the
        attitude, the angle between the two attitudes, rad
    why : the common mistake that explains the difference, in words; empty if none does
    """

    what: str
    wanted: FloatArray
    got: FloatArray
    relative: float
    why: str = ""

    @property
    def complaint(self) -> str:
        """The message of a run that fails because of the difference, with all digits."""
        wanted, got = self.wanted.tolist(), self.got.tolist()
        why = f": {self.why}" if self.why else ""
        return f"'{self.what}' must read back as {wanted}, got {got}{why}"

    @property
    def remark(self) -> str:
        """The message of a run that goes on in spite of the difference, with rounded values."""
        # A difference that is not a number, as where an engine reads back one, shows in any digit.
        relative = 1.0 if math.isnan(self.relative) else min(self.relative, 1.0)
        digits = max(3, 2 - math.floor(math.log10(relative)))
        wanted, got = _rounded(self.wanted, digits), _rounded(self.got, digits)
        off = f"off by {100 * self.relative:.2g}%"
        return f"'{self.what}' reads back as {got}, not {wanted}: {off}"


def differences(
    scenario: Scenario, reading: BodyReading, state: State, slack: float, length: float = 0.0
) -> list[Difference]:
    """Return the quantities of body and start that differ between the engine and the scene.

    Parameters
    ----------
    reading, state : the body and the state, read back from the engine before the first step
    slack : allowed difference, relative to the size of each quantity; of the attitude, rad
    length : a size of the body, m: differences of the com are relative to it if the com is closer
        to the origin

    Returns
    -------
    The quantities that differ by more than `slack`; an attitude with a known mistake, which may
    explain other differences, comes first
    """
    differing = []
    steiner = OF_ORIGIN * scenario.body.mass * float(scenario.body.com @ scenario.body.com)
    for what, got, wanted, size in _pairs(scenario, reading, state, length):
        largest = float(np.abs(np.subtract(got, wanted)).max())
        if not largest <= slack * (size + (steiner if what == "inertia_com" else 0.0)):
            relative = largest / size if size else np.inf
            why = _mistake_of_axes(scenario, got, slack * size) if what == "omega_body" else ""
            differing.append(Difference(what, wanted, got, relative, why))
    wanted_q, got_q = scenario.start.q_world_body_wxyz, state.q_world_body_wxyz
    angle = float(norms(rotation_vectors(got_q[None], wanted_q[None]))[0])
    if not angle <= slack:
        words = _mistake_of_attitude(wanted_q, got_q, slack)
        off = Difference("q_world_body_wxyz", wanted_q, got_q, angle, words)
        # A known mistake of the attitude also explains a difference of ω: it is named first.
        differing.insert(0 if words else len(differing), off)
    return differing


def _mistake_of_attitude(wanted_q: FloatArray, got_q: FloatArray, slack: float) -> str:
    """Return, in words, the common mistake that turns the scene's quaternion into the engine's.

    The words are empty if no known mistake does so.

    Parameters
    ----------
    wanted_q, got_q : the scene's quaternion and the engine's, w x y z, (4,)
    slack : the allowed angle between attitudes, rad
    """
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


def _mistake_of_axes(scenario: Scenario, got: FloatArray, slack: float) -> str:
    """Return a message if ω was read back in world axes instead of body axes, or the reverse.

    The text is empty if it was not. Such a mistake shows as the scene's components of ω rotated by
    the attitude or its inverse.

    Parameters
    ----------
    got : ω as read back, rad/s, (3,)
    slack : allowed difference of a component, rad/s
    """
    R_world_body, omega_body = matrix(scenario.start.q_world_body_wxyz), scenario.start.omega_body
    for turned in (R_world_body @ omega_body, omega_body @ R_world_body):
        if np.abs(got - turned).max() <= slack:
            return "its components are along the other axes, the world's for the body's or reverse"
    return ""


def stated_body(scenario: Scenario) -> BodyReading:
    """Return the scene's body, with its rotors, as an engine should hold it."""
    body = scenario.body
    return BodyReading(body.mass, body.com, body.inertia_com, scenario.rotors.axial_body)


def start_state(scenario: Scenario) -> State:
    """Return the scene's start as a state; com and velocity are those that the constraint demands.

    Along axes that are not held, they are those that the scene states.
    """
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
    scenario: Scenario, reading: BodyReading, state: State, length: float
) -> Iterator[tuple[str, FloatArray, FloatArray, float]]:
    """Yield four values for each quantity that is read back, except the attitude.

    The values are the quantity's name, the engine's value, the scene's value, and the size that the
    tolerance is relative to. `reading` and `state` are body and start as the engine holds them;
    `length`, m, is the least size of the com.
    """
    body, start = scenario.body, start_state(scenario)
    arm = max(length, float(np.linalg.norm(body.com)))
    speed = float(np.linalg.norm(start.omega_body))
    # The size of the tensor is that about the com: about an origin far from the com it is much
    # larger, and faults of the tensor about the com would not exceed the tolerance.
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
    """Yield the name, the engine's value and the scene's value of each quantity of the body.

    `reading` is the body as the engine holds it.
    """
    body = stated_body(scenario)
    yield "mass", np.array(reading.mass), np.array(body.mass)
    yield "com", reading.com, body.com
    yield "inertia_com", reading.inertia_com, body.inertia_com
    for number, axial in enumerate(body.axial, start=1):
        yield f"axial moment of rotor {number}", reading.axial[number - 1], axial


def _rounded(values: FloatArray, digits: int) -> str:
    """Return an array as text, with so many digits, and entries of the size of round-off as 0."""
    least = float(np.finfo(float).eps) * np.abs(values).max()
    shown = np.where(np.abs(values) > least, values, 0.0)
    written = np.array2string(
        shown, separator=", ", formatter={"float_kind": f"{{:.{digits}g}}".format}
    )
    return written.replace("\n", "")
