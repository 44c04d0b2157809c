"""Converts scenes and motions to other axes, another origin of the body, and other units."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from mpmath import mp, mpf

from ...scenarios import Body, FloatArray, Scenario
from ...scenarios.effects import EFFECTS, Effects
from ...scenarios.effects.effect import Unit
from ...scenarios.exact import (
    DIGITS,
    NO_TURN,
    ZERO,
    Quaternion,
    Tensor,
    Vector,
    conjugate,
    product,
    rotate,
    turned_tensor,
    vector,
)
from ...scenarios.gyrostat import Rotor, Rotors
from ...scenarios.rotation import matrix, times
from ...scenarios.scenario import with_tables
from ...scenarios.start import Start
from ..checks.read_back import BodyReading, State

#: Factors of the components when x is mirrored: of polar vectors, axial vectors and quaternions.
_POLAR, _AXIAL = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0])
_MIRRORED_Q = np.array([1.0, 1.0, -1.0, -1.0])

#: Names of the effects that scenes of an encoding may have. For encodings by other axes or units
#: these are all effects. `OF_BODIES` is for encodings that write the body differently,
#: `OF_ONE_BODY` for those that need a body without rotors, and `FREE_FALL` for those that need a
#: body on which only gravity acts.
ON_A_TABLE = frozenset(EFFECTS)
OF_BODIES = ON_A_TABLE - {"table"}
OF_ONE_BODY = OF_BODIES - {"rotors"}
FREE_FALL = frozenset({"gravity", "rotors"})
#: Number of changed bodies that are kept, as a scene is opened again from many states.
KEPT = 64


@dataclass(frozen=True)
class SceneChange:
    """How a scene is changed, and how motions of the changed scene are converted back.

    Attributes
    ----------
    q_body_new : quaternion that takes components along the new body axes to the old ones
    shift : vector from the old to the new origin of the body, m, along the old body axes
    length, mass, time : the number of new units in one old unit of length, mass and time
    is_mirrored : whether the x axes of world and body are reversed
    """

    q_body_new: Quaternion = NO_TURN
    shift: Vector = ZERO
    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0
    is_mirrored: bool = False

    def scene(self, scenario: Scenario) -> Scenario:
        """Return a scene in the new axes, origin and units.

        Its body and start are converted in extended precision.
        """
        with mp.workdps(DIGITS):
            window = scenario.window.model_copy(
                update={"duration": scenario.window.duration * self.time}
            )
            changed = with_tables(scenario, window=window, effects=self._effects(scenario.effects))
            return replace(
                changed,
                carrier=_changed(self, scenario.carrier),
                rotors=Rotors(tuple(map(self._rotor, scenario.rotors.each))),
                start=self._start(scenario),
            )

    def _body(self, body: Body) -> Body:
        """Return a body of the scene in the new axes, origin and units."""
        scale = self._moment
        rows = turned_tensor(body.inertia_com_exact, self.q_body_new)
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
            (a * scale, b * scale, c * scale) for a, b, c in rows
        )
        if self.is_mirrored:
            xy, xz = -xy, -xz
        tensor: Tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        return Body(body.mass_exact * mpf(self.mass), self._point(body.com_exact), tensor)

    def _rotor(self, rotor: Rotor) -> Rotor:
        """Return a rotor of the scene in the new axes, origin and units."""
        return Rotor(
            self._axial(rotate(conjugate(self.q_body_new), rotor.axis)),
            self._point(rotor.position),
            rotor.mass * mpf(self.mass),
            rotor.across * self._moment,
            rotor.along * self._moment,
            rotor.spin / mpf(self.time),
            rotor.hinge,
        )

    def _point(self, place: Vector) -> Vector:
        """Return a point of the body, m from the old origin, in the new axes, origin and units."""
        (a, b, c), (p, q, r) = place, self.shift
        x, y, z = self._polar(rotate(conjugate(self.q_body_new), (a - p, b - q, c - r)))
        return (x * self.length, y * self.length, z * self.length)

    @property
    def _moment(self) -> mpf:
        """The number of new units of a moment of inertia in one old unit."""
        return mpf(self.mass) * mpf(self.length) ** 2

    def _start(self, scenario: Scenario) -> Start:
        """Return the scene's start in the new axes and units."""
        start = scenario.start
        x, y, z = rotate(conjugate(self.q_body_new), start.omega_body_exact)
        omega = self._axial((x / self.time, y / self.time, z / self.time))
        return Start(
            self._attitude(product(start.q_exact, self.q_body_new)),
            omega,
            start.position_world * self._sign * self.length,
            start.velocity_world * self._sign * self.length / self.time,
        )

    def _effects(self, effects: Effects) -> Effects:
        """Return the tables of effects with their numbers in the new axes and units."""
        return Effects.model_validate(
            {
                name: {
                    key: self._number(number, table.UNITS[key])
                    for key, number in table.model_dump(exclude_none=True).items()
                }
                for name, table in effects
                if table is not None
            }
        )

    def _number(self, number: Any, unit: Unit) -> float | tuple[float, ...]:
        """Return a number or vector of an effect in the new units and axes.

        Parameters
        ----------
        number : the number or vector as the scene states it
        unit : exponents of its units of mass, length and time, and the kind and axes of a vector
        """
        units = (self.mass, unit.mass), (self.length, unit.length), (self.time, unit.time)
        scale = mp.fprod(mpf(one) ** power for one, power in units)
        if unit.kind == "scalar":
            return float(number * scale)
        along = vector(number)
        if unit.axes == "body":
            along = rotate(conjugate(self.q_body_new), along)
        mirrored = self._axial(along) if unit.kind == "axial" else self._polar(along)
        return tuple(float(part * scale) for part in mirrored)

    def state(self, state: State) -> State:
        """Return the state of the changed scene that corresponds to one of the original scene.

        It is converted in double precision.
        """
        q_new = state.q_world_body_wxyz @ times(np.array([float(c) for c in self.q_body_new]))
        omega_new = state.omega_body @ self._R_body_new / self.time
        if self.is_mirrored:
            omega_new, q_new = omega_new * _AXIAL, q_new * _MIRRORED_Q
        sign = self._sign
        return State(
            q_new,
            omega_new,
            state.com_world * sign * self.length,
            state.velocity_world * sign * self.length / self.time,
            state.spins / self.time,
        )

    def state_back(self, states: State) -> State:
        """Return the n states of the original scene that correspond to n of the changed scene."""
        back = times(np.array([float(c) for c in conjugate(self.q_body_new)]))
        R_body_new = self._R_body_new
        omega_new, q_new = states.omega_body, states.q_world_body_wxyz
        if self.is_mirrored:
            omega_new, q_new = omega_new * _AXIAL, q_new * _MIRRORED_Q
        sign = self._sign
        return State(
            q_new @ back,
            omega_new @ R_body_new.T * self.time,
            states.com_world * sign / self.length,
            states.velocity_world * sign * self.time / self.length,
            states.spins * self.time,
        )

    def body_back(self, body: BodyReading) -> BodyReading:
        """Return a body of the changed scene in the axes, origin and units of the original."""
        R = self._R_body_new
        sign = self._sign
        com, tensor = body.com * sign / self.length, body.inertia_com * np.outer(sign, sign)
        unit = self.mass * self.length**2
        axial = body.axial * (_AXIAL if self.is_mirrored else 1.0) / unit
        alone = BodyReading(body.mass / self.mass, com, tensor / unit, axial)
        return alone.placed(np.array([float(c) for c in self.shift]), R)

    @property
    def _R_body_new(self) -> FloatArray:
        """The matrix that takes components along the new body axes to the old ones, (3, 3)."""
        return matrix(np.array([float(c) for c in self.q_body_new]))

    @property
    def _sign(self) -> FloatArray:
        """Factors of the components of a polar vector: −1 for x if the scene is mirrored, (3,)."""
        return _POLAR if self.is_mirrored else np.ones(3)

    def _polar(self, vector: Vector) -> Vector:
        """Return a polar vector, mirrored if the scene is mirrored."""
        x, y, z = vector
        return (-x, y, z) if self.is_mirrored else (x, y, z)

    def _axial(self, vector: Vector) -> Vector:
        """Return an axial vector, such as ω, mirrored if the scene is mirrored."""
        x, y, z = vector
        return (x, -y, -z) if self.is_mirrored else vector

    def _attitude(self, q: Quaternion) -> Quaternion:
        """Return the quaternion of an attitude, w x y z, mirrored if the scene is mirrored."""
        w, x, y, z = q
        return (w, x, -y, -z) if self.is_mirrored else q


@lru_cache(maxsize=KEPT)
def _changed(change: SceneChange, body: Body) -> Body:
    """Return a body in the axes, origin and units of a changed scene; recent results are cached."""
    with mp.workdps(DIGITS):
        return change._body(body)
