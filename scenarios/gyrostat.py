"""A gyrostat: a body with rotors, axisymmetric parts on frictionless hinges.

A rotor looks the same at every angle, so that com and inertia of the whole stay as they are in
body axes. With s the spin relative to the body, C the moment along the unit axis u and I the
inertia of the whole (J. Wittenburg, Dynamics of Multibody Systems, 2nd ed., §4.6)::

    L = I ω + Σ C s u        T = ½ ω·I ω + Σ (C s u·ω + ½ C s²)

A free hinge passes on no axial torque: C (u·ω + s) stays, and the rotor's axial moment is no part
of what ω' is multiplied by. A driven one keeps s, a locked one has none.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from mpmath import mp, mpf
from numpy.typing import NDArray

from .body import Body
from .exact import DIGITS, ZERO, Tensor, Vector, add, dot, steiner
from .float_array import FloatArray, read_only

#: Bodies with rotors that are kept as a whole.
KEPT = 64


@dataclass(frozen=True, eq=False)
class Rotor:
    """A rotor in extended precision; SI units, body axes.

    Attributes
    ----------
    axis : of unit length
    position : of its com, from the body's origin
    across, along : moments about its com
    spin : relative to the body, at t = 0
    """

    axis: Vector
    position: Vector
    mass: mpf
    across: mpf
    along: mpf
    spin: mpf
    hinge: Literal["free", "driven", "locked"]

    @cached_property
    def body(self) -> Body:
        """The rotor as a body by itself, along the axes of the carrier and from its origin."""
        return Body(self.mass, self.position, self.inertia)

    @property
    def inertia(self) -> Tensor:
        """About its com, kg m²: A 1 + (C − A) u uᵀ."""
        zero, A = mpf(0), self.across
        isotropic = ((A, zero, zero), (zero, A, zero), (zero, zero, A))
        return add(isotropic, self.about_axis(self.along - self.across))

    def about_axis(self, moment: mpf) -> Tensor:
        """A moment about its axis alone, kg m²."""
        with mp.workdps(DIGITS):
            u, v, w = self.axis
            return (
                (moment * u * u, moment * u * v, moment * u * w),
                (moment * v * u, moment * v * v, moment * v * w),
                (moment * w * u, moment * w * v, moment * w * w),
            )


@dataclass(frozen=True, eq=False)
class Rotors:
    """All rotors of a body."""

    each: tuple[Rotor, ...]

    def __bool__(self) -> bool:
        return bool(self.each)

    @cached_property
    def along(self) -> FloatArray:
        """Moments along the axes, kg m², (rotors,)."""
        return read_only([rotor.along for rotor in self.each])

    @cached_property
    def axes_body(self) -> FloatArray:
        """Their axes, (rotors, 3)."""
        return read_only([rotor.axis for rotor in self.each]).reshape(-1, 3)

    @cached_property
    def is_free(self) -> FloatArray:
        """1 where the hinge is free, else 0, (rotors,)."""
        return read_only([float(rotor.hinge == "free") for rotor in self.each])

    @cached_property
    def is_turning(self) -> NDArray[np.bool_]:
        """Whether the hinge is not locked, (rotors,)."""
        return np.array([rotor.hinge != "locked" for rotor in self.each], dtype=bool)

    @cached_property
    def axial_body(self) -> FloatArray:
        """What a spin is multiplied by in L, C u, kg m², (rotors, 3); zero where one is locked."""
        return read_only((self.along * self.is_turning)[:, None] * self.axes_body)

    @cached_property
    def start_spins(self) -> FloatArray:
        """Spins at t = 0, relative to the body, rad/s, (rotors,)."""
        return read_only([rotor.spin for rotor in self.each])

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """What each hinge keeps, kg m²/s, (n, rotors): C (u·ω + s) if it is free, C s if not."""
        turned = omega_body @ self.axes_body.T * self.is_free
        return np.asarray(self.along * (spins + turned))

    def spins(self, omega_body: FloatArray, kept: FloatArray) -> FloatArray:
        """The spins of rotors that keep so much, rad/s, (n, rotors)."""
        turned = omega_body @ self.axes_body.T * self.is_free
        return np.asarray(kept / self.along - turned)

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """The sum of what the hinges keep, kg m²/s, (n, 3): what is added to I ω in L."""
        return np.asarray(kept @ self.axes_body)

    def cancelling(
        self, spins: FloatArray, com_body: FloatArray, far: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Σ m r s², N, and Σ (C + m d r) s², N m, (n,), d from the com of all, r = d + far.

        Terms that coordinates which turn with a rotor have, and that cancel; places are rounded
        relative to their distance from an origin, m, that is so far away.
        """
        masses = np.array([rotor.body.mass for rotor in self.each])
        places = np.array([rotor.body.com for rotor in self.each]).reshape(-1, 3)
        apart = np.linalg.norm(places - com_body, axis=1)
        squares, reach = spins * spins, apart + far
        return squares @ (masses * reach), squares @ (self.along + masses * apart * reach)

    def sizes(self, omega_body: FloatArray) -> tuple[FloatArray, float]:
        """|C s| + C |u·ω| at the start, kg m²/s, (rotors,), and the energy that comes to, J.

        None is zero where it can turn.
        """
        turned = np.abs(self.axes_body @ omega_body)
        kept = np.asarray(self.along * (np.abs(self.start_spins) + turned))
        return kept, float(kept @ (kept / self.along)) / 2

    def momentum_body(self, spins: FloatArray) -> FloatArray:
        """Σ C s u, kg m²/s, (n, 3): what they add to L."""
        return np.asarray(spins @ self.axial_body)

    def energy(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Σ (C s u·ω + ½ C s²), J, (n,): what they add to T."""
        turned = omega_body @ self.axes_body.T
        return np.asarray((self.along * spins * (turned + spins / 2)).sum(axis=-1))

    def work(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Σ C s u·ω of driven rotors, J, (n,): its change is the work of their drives."""
        turned = omega_body @ self.axes_body.T * (1 - self.is_free)
        return np.asarray((self.along * spins * turned).sum(axis=-1))


def whole(body: Body, rotors: Rotors) -> Body:
    """A body with its rotors as if their hinges were locked.

    Raises
    ------
    ValueError
        If it is too large to be computed with.
    """
    return _composed(body, rotors) if rotors else body


@lru_cache(maxsize=KEPT)
def _composed(body: Body, rotors: Rotors) -> Body:
    parts = [(body.mass_exact, body.com_exact, body.inertia_com_exact)]
    parts += [(rotor.mass, rotor.position, rotor.inertia) for rotor in rotors.each]
    with mp.workdps(DIGITS):
        mass = mp.fsum(part[0] for part in parts)
        x, y, z = (mp.fsum(m * place[k] for m, place, _ in parts) / mass for k in range(3))
        inertia: Tensor = (ZERO, ZERO, ZERO)
        for part_mass, place, tensor in parts:
            arm = (place[0] - x, place[1] - y, place[2] - z)
            inertia = add(add(inertia, tensor), steiner(part_mass, arm))
    return Body(mass, (x, y, z), inertia)


def without_free_axes(inertia: Tensor, rotors: Rotors) -> Tensor:
    """Inertia less the axial moments of rotors that turn freely."""
    for rotor in rotors.each:
        if rotor.hinge == "free":
            inertia = add(inertia, rotor.about_axis(rotor.along), sign=-1)
    return inertia


def kept_exact(rotor: Rotor, omega_body: Vector) -> mpf:
    """As `Rotors.kept`, of one rotor at the start, in extended precision."""
    with mp.workdps(DIGITS):
        turned = dot(rotor.axis, omega_body) if rotor.hinge == "free" else mpf(0)
        return rotor.along * (rotor.spin + turned)
