"""A gyrostat: a body with rotors, axisymmetric parts on hinges: free, driven or locked.

A rotor looks the same at every angle, so that com and inertia of the whole stay as they are in
body axes. With s the spin relative to the body, C the moment along the unit axis u and I the
inertia of the whole (J. Wittenburg, Dynamics of Multibody Systems, 2nd ed., §4.6)::

    L = I ω + Σ C s u        T = ½ ω·I ω + Σ (C s u·ω + ½ C s²)

A free hinge transmits no axial torque: C (u·ω + s) stays constant, and the inertia that multiplies
ω' leaves out the rotor's axial moment. A driven rotor keeps s constant, a locked one has s = 0.
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

#: Number of bodies whose sum with their rotors is kept.
KEPT = 64


@dataclass(frozen=True, eq=False)
class Rotor:
    """A rotor in extended precision; SI units, body axes.

    Attributes
    ----------
    axis : the axle as a unit vector
    position : position of the rotor's com, from the body's origin
    mass : mass of the rotor
    across, along : moments about the rotor's com, across and along the axis
    spin : angular velocity about the axis relative to the body, at t = 0
    hinge : "free" without friction, "driven" at a constant spin, or "locked"
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
        """The rotor by itself as a rigid body, in the frame of the body that carries it."""
        return Body(self.mass, self.position, self.inertia)

    @property
    def inertia(self) -> Tensor:
        """Inertia about the rotor's com, kg m², body axes.

        It is A 1 + (C − A) u uᵀ, with u the axis, and A and C the moments across and along it.
        """
        zero, A = mpf(0), self.across
        isotropic = ((A, zero, zero), (zero, A, zero), (zero, zero, A))
        return add(isotropic, self.about_axis(self.along - self.across))

    def about_axis(self, moment: mpf) -> Tensor:
        """Return the tensor of a moment about the rotor's axis u alone, moment · u uᵀ, kg m²."""
        with mp.workdps(DIGITS):
            u, v, w = self.axis
            return (
                (moment * u * u, moment * u * v, moment * u * w),
                (moment * v * u, moment * v * v, moment * v * w),
                (moment * w * u, moment * w * v, moment * w * w),
            )


@dataclass(frozen=True, eq=False)
class Rotors:
    """All rotors of a body; as a truth value, whether there are any.

    In formulas u is the unit vector of a rotor's axis, body axes, C the rotor's moment of inertia
    about it, kg m², and s its spin, rad/s.

    Attributes
    ----------
    each : the rotors, in the order of the scene's file
    """

    each: tuple[Rotor, ...]

    def __bool__(self) -> bool:
        return bool(self.each)

    @cached_property
    def along(self) -> FloatArray:
        """Moments of the rotors along their axes, kg m², (rotors,)."""
        return read_only([rotor.along for rotor in self.each])

    @cached_property
    def axes_body(self) -> FloatArray:
        """Unit vectors of the rotors' axes, body axes, (rotors, 3)."""
        return read_only([rotor.axis for rotor in self.each]).reshape(-1, 3)

    @cached_property
    def is_free(self) -> FloatArray:
        """1 for each rotor whose hinge is free, else 0, (rotors,)."""
        return read_only([float(rotor.hinge == "free") for rotor in self.each])

    @cached_property
    def is_turning(self) -> NDArray[np.bool_]:
        """Whether each rotor's hinge is not locked, (rotors,)."""
        return np.array([rotor.hinge != "locked" for rotor in self.each], dtype=bool)

    @cached_property
    def axial_body(self) -> FloatArray:
        """Each rotor's axis times its moment about the axis, kg m², body axes, (rotors, 3).

        It is zero for a locked rotor. Multiplied by the rotor's spin it is what the spin adds to
        the angular momentum L.
        """
        return read_only((self.along * self.is_turning)[:, None] * self.axes_body)

    @cached_property
    def start_spins(self) -> FloatArray:
        """Spins of the rotors at t = 0, relative to the body, rad/s, (rotors,)."""
        return read_only([rotor.spin for rotor in self.each])

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return each rotor's constant angular momentum about its axle, kg m²/s, (n, rotors).

        It is C (u·ω + s) on a free hinge and C s on any other, with u the unit vector of the axle
        and C the rotor's moment about it.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        spins : spins s of the rotors in these states, rad/s, (n, rotors)
        """
        turned = omega_body @ self.axes_body.T * self.is_free
        return np.asarray(self.along * (spins + turned))

    def spins(self, omega_body: FloatArray, kept: FloatArray) -> FloatArray:
        """Return the rotors' spins, rad/s, (n, rotors), given their constant angular momenta.

        It is the inverse of `Rotors.kept`.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        kept : each rotor's constant angular momentum about its axle, from `Rotors.kept`, kg m²/s,
            in these states, (n, rotors), or the same in all of them, (rotors,)
        """
        turned = omega_body @ self.axes_body.T * self.is_free
        return np.asarray(kept / self.along - turned)

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """Return the vector sum of the rotors' angular momenta, kg m²/s, body axes, (n, 3) or (3,).

        The angular momentum L is I ω plus this sum, if I leaves out the axial moments of rotors on
        free hinges.

        Parameters
        ----------
        kept : each rotor's constant angular momentum about its axle, from `Rotors.kept`, kg m²/s,
            in n states, (n, rotors), or in one, (rotors,)
        """
        return np.asarray(kept @ self.axes_body)

    def cancelling(
        self, spins: FloatArray, com_body: FloatArray, far: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Return sizes of inertial forces, N, and torques, N m, that cancel each other, (n,) each.

        They arise in coordinates that turn with a rotor. An engine that uses such coordinates sums
        them, with rounding errors in proportion to their sizes: Σ m r s² of the forces and
        Σ (C + m d r) s² of the torques, with C a rotor's moment about its axle, m its mass, d its
        distance from the com, and r = d + `far` a bound on its distance from the origin of the
        coordinates.

        Parameters
        ----------
        spins : spins s of the rotors in n states, rad/s, (n, rotors)
        com_body : the com, m, body axes, (3,)
        far : distance of the coordinates' origin from the com, m
        """
        masses = np.array([rotor.body.mass for rotor in self.each])
        places = np.array([rotor.body.com for rotor in self.each]).reshape(-1, 3)
        apart = np.linalg.norm(places - com_body, axis=1)
        squares, reach = spins * spins, apart + far
        return squares @ (masses * reach), squares @ (self.along + masses * apart * reach)

    def sizes(self, omega_body: FloatArray) -> tuple[FloatArray, float]:
        """Return sizes of the rotors' angular momenta, kg m²/s, (rotors,), and of their energy, J.

        With C a rotor's moment about its axle u and s its spin, both at the start, the size of its
        angular momentum is C (|s| + |u·ω|), and the size of the energy is Σ ½ C (|s| + |u·ω|)². A
        size is zero only if at the start the rotor turns about its axle neither in the body nor
        together with it.

        Parameters
        ----------
        omega_body : ω at the start, rad/s, body axes, (3,)
        """
        turned = np.abs(self.axes_body @ omega_body)
        kept = np.asarray(self.along * (np.abs(self.start_spins) + turned))
        return kept, float(kept @ (kept / self.along)) / 2

    def momentum_body(self, spins: FloatArray) -> FloatArray:
        """Return what the rotors' spins add to L, kg m²/s, body axes, (n, 3).

        It is Σ C s u, with C the moment of a rotor about its axle and u the axle's unit vector.

        Parameters
        ----------
        spins : spins s of the rotors in n states, rad/s, (n, rotors)
        """
        return np.asarray(spins @ self.axial_body)

    def energy(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return what the rotors' spins add to the kinetic energy, J, (n,).

        It is Σ (C s u·ω + ½ C s²), with C the moment of a rotor about its axle u, a unit vector.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        spins : spins s of the rotors in these states, rad/s, (n, rotors)
        """
        turned = omega_body @ self.axes_body.T
        return np.asarray((self.along * spins * (turned + spins / 2)).sum(axis=-1))

    def work(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return Σ C s u·ω of driven rotors, J, (n,), with C the moment about the axle u.

        Its change along a motion is the work of the motors that keep their spins constant.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        spins : spins s of the rotors in these states, rad/s, (n, rotors)
        """
        turned = omega_body @ self.axes_body.T * (1 - self.is_free)
        return np.asarray((self.along * spins * turned).sum(axis=-1))


def whole(body: Body, rotors: Rotors) -> Body:
    """Return a body together with its rotors as one rigid body, as if their hinges were locked.

    Raises
    ------
    ValueError
        If the body is too large to be computed with.
    """
    return _composed(body, rotors) if rotors else body


@lru_cache(maxsize=KEPT)
def _composed(body: Body, rotors: Rotors) -> Body:
    """Return a body with its rotors as one rigid body, as `whole` does."""
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
    """Return an inertia tensor minus the axial moments of rotors on free hinges, kg m²."""
    for rotor in rotors.each:
        if rotor.hinge == "free":
            inertia = add(inertia, rotor.about_axis(rotor.along), sign=-1)
    return inertia


def kept_exact(rotor: Rotor, omega_body: Vector) -> mpf:
    """Return the constant angular momentum of one rotor about its axle, kg m²/s.

    It is what `Rotors.kept` returns for t = 0, but in extended precision.

    Parameters
    ----------
    omega_body : ω at t = 0, rad/s, body axes
    """
    with mp.workdps(DIGITS):
        turned = dot(rotor.axis, omega_body) if rotor.hinge == "free" else mpf(0)
        return rotor.along * (rotor.spin + turned)
