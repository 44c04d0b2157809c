"""The initial value problem that every solver is given: principal axes, extended precision."""

from dataclasses import dataclass, replace

from mpmath import mp, mpf

from ..scenarios.exact import DIGITS, ZERO, Quaternion, Vector, dot

_ONE = mpf(1)


@dataclass(frozen=True, eq=False)
class Problem:
    """Rotation of a rigid body about a fixed point (its pivot, else its centre of mass).

    In names, "axes" means the principal axes through that point; every quaternion is w, x, y, z.
    Equal moments are exactly equal here, so that a solver may test them with ``==``.

    Attributes
    ----------
    moments : principal moments of inertia about the fixed point, kg m². A rotor on a free hinge
        contributes nothing about its axle
    q_world_axes : attitude at t = 0, of unit norm to working precision
    omega_axes : angular velocity at t = 0 along the principal axes, rad/s
    lever_axes : mass times the vector from the fixed point to the centre of mass, kg m; zero unless
        the scene has both a pivot and gravity
    gravity_world : acceleration, m/s², world axes
    torque_axes : torque that is constant along the principal axes, N m
    torque_world : torque that is constant along the world axes, N m
    drag : coefficient c of the torque −c ω, N m s
    tip_axes : vector from the centre of mass to the centre of the sphere that slides on a table, m;
        zero without a table
    tip_radius : radius of that sphere, m
    ends_at_lift_off : whether the motion ends where the table would have to pull
    mass : mass of a body on a table, kg; 1 without a table, where it is not used
    q_axes_body : quaternion that takes body components to components along the principal axes
    kept : for each rotor, its constant angular momentum about its axle, kg m²/s
    kept_axes : for each rotor, the unit vector of its axle along the principal axes
    """

    moments: Vector
    q_world_axes: Quaternion
    omega_axes: Vector
    lever_axes: Vector
    gravity_world: Vector
    torque_axes: Vector
    torque_world: Vector
    drag: mpf
    q_axes_body: Quaternion
    tip_axes: Vector = ZERO
    tip_radius: mpf = ZERO[0]
    ends_at_lift_off: bool = True
    mass: mpf = _ONE
    kept: tuple[mpf, ...] = ()
    kept_axes: tuple[Vector, ...] = ()

    @property
    def slides(self) -> bool:
        """Whether the body has a tip, other than its com, that slides on a table."""
        return any(self.tip_axes)

    @property
    def held_lever(self) -> Vector:
        """Mass times the vector from pivot or tip to the com, kg m, along the principal axes.

        It is zero for a free body, and for a body on a pivot without gravity.
        """
        if not self.slides:
            return self.lever_axes
        with mp.workdps(DIGITS):
            x, y, z = (-self.mass * component for component in self.tip_axes)
            return (x, y, z)

    @property
    def heaving(self) -> mpf:
        """m l², kg m², with l the distance from tip to com of a body on a table; 0 without one.

        A body that tilts on a table raises or lowers its com: m l² sin²β, with β the angle of
        tilt, adds to its inertia against tilting.
        """
        return mp.sqrt(dot(self.tip_axes, self.tip_axes)) ** 2 * self.mass

    def lengthened(self, factor: mpf) -> "Problem":
        """Return the problem with the vector from pivot or tip to com multiplied by a factor.

        On a table, its motion does not end at lift-off.
        """
        levers = {
            name: tuple(factor * component for component in getattr(self, name))
            for name in ("lever_axes", "tip_axes")
        }
        return replace(self, ends_at_lift_off=False, **levers)

    @property
    def kept_momentum(self) -> Vector:
        """Σ kept · axis, kg m²/s: what rotors add to I ω in the angular momentum L."""
        with mp.workdps(DIGITS):
            total = ZERO
            for kept, (u, v, w) in zip(self.kept, self.kept_axes, strict=True):
                total = (total[0] + kept * u, total[1] + kept * v, total[2] + kept * w)
            return total
