"""A top's motion in sixty digits by plain Taylor series, and a million periods on by group theory.

Nothing here knows of theta functions. The equations of motion are integrated in fixed-point
integers over little more than one period T. After it the motion repeats but for a turn about the
vertical (about L, for a free body) and one about the body's third axis, so that in Cayley–Klein
parameters A(t + nT) = A(t) ρᴬⁿ, B(t + nT) = B(t) ρᴮⁿ with constant ρ of modulus one.
"""

from mpmath import mp, mpc, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios.exact import Quaternion, Vector, conjugate, dot, product, rotate

DIGITS = 60
BITS = 260
#: Step over the distance of the nearest pole of the motion as a function of complex time.
STEP = mpf(1) / 3
#: rad, at most, turned in a step: of e^{8i}, the series leaves out 8^101/101! = 2e-69.
TURN = 8
#: STEP^ORDER = 2e-48, to be multiplied by a few hundred steps.
ORDER = 100
CYCLIC = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def fixed(x: mpf) -> int:
    """x in units of 2^-BITS."""
    return int(mp.nint(mp.ldexp(x, BITS)))


class ExtendedMotion:
    """The motion of a problem without drag and torques over a span.

    Parameters
    ----------
    pole : s, distance of the nearest singularity from the real axis of time, K'/p
    rate : rad/s, that no angular velocity exceeds by far
    span : s
    """

    def __init__(self, problem: Problem, pole: mpf, rate: mpf, span: mpf) -> None:
        with mp.workdps(DIGITS):
            self.h = min(STEP * pole, TURN / rate)
            steps = int(span / self.h) + 1
            moments, lever = problem.moments, problem.lever_axes
            self.factors = [
                [fixed(self.h * f) for f in ((moments[j] - moments[k]) / moments[i], 1)]
                + [fixed(self.h * f / moments[i]) for f in (lever[j], -lever[k])]
                for i, j, k in CYCLIC
            ]
            gravity = rotate(conjugate(problem.q_world_axes), problem.gravity_world)
            state = [fixed(x) for x in (*problem.omega_axes, *problem.q_world_axes, *gravity)]
            self.pieces = []
            for _ in range(steps):
                self.pieces.append(self._series(state))
                state = [sum(column) for column in self.pieces[-1]]

    def _series(self, state: list[int]) -> list[list[int]]:
        """Taylor coefficients of ω, q and gravity along the axes, times hⁿ."""
        columns = [[x] for x in state]
        w, q, g = columns[:3], columns[3:7], columns[7:]
        half = self.factors[0][1] // 2
        for n in range(ORDER):

            def times(a: list[int], b: list[int]) -> int:
                return sum(map(int.__mul__, a, reversed(b))) >> BITS

            new = []
            for (_, j, k), (euler, _, next_, after) in zip(CYCLIC, self.factors, strict=True):
                new.append(euler * times(w[j], w[k]) + next_ * g[k][n] + after * g[j][n])
            q0, vector = q[0], q[1:]
            new.append(-half * sum(times(vector[i], w[i]) for i in range(3)))
            for i, j, k in CYCLIC:
                turned = times(q0, w[i]) + times(vector[j], w[k]) - times(vector[k], w[j])
                new.append(half * turned)
            for i, j, k in CYCLIC:
                new.append(self.factors[i][1] * (times(g[j], w[k]) - times(g[k], w[j])))
            for column, value in zip(columns, new, strict=True):
                column.append((value >> BITS) // (n + 1))
        return columns

    def state(self, t: mpf) -> tuple[Quaternion, Vector]:
        """q_world_axes and omega_axes at a time in the span."""
        with mp.workdps(DIGITS):
            piece = int(t / self.h)
            s = t / self.h - piece
            powers = [s**n for n in range(ORDER + 1)]
            values = [mp.ldexp(mp.fdot(column, powers), -BITS) for column in self.pieces[piece]]
        return tuple(values[3:7]), tuple(values[:3])


class RepeatedMotion:
    """A motion at any time, from one period and what one period turns it by.

    Parameters
    ----------
    period : s, after which ω repeats up to a turn about the third axis
    vertical_world : direction that each period turns the motion about
    """

    def __init__(self, motion: ExtendedMotion, period: mpf, vertical_world: Vector) -> None:
        with mp.workdps(DIGITS):
            self.motion, self.period = motion, period
            self.to_upright = upright(vertical_world)
            reference = period / 7  # any time at which neither A nor B vanishes
            early, late = (self._parameters(reference + n * period) for n in range(2))
            self.ratios = [b / a for a, b in zip(early, late, strict=True)]
            #: How far the moduli of A and B are from repeating: whether the period is one.
            self.mismatch = max(abs(abs(ratio) - 1) for ratio in self.ratios)

    def _parameters(self, t: mpf) -> tuple[mpc, mpc]:
        q = product(self.to_upright, self.motion.state(t)[0])
        return mpc(q[0], q[3]), mpc(q[2], -q[1])

    def state(self, t: float) -> tuple[Quaternion, Vector]:
        """q_world_axes, and omega_axes turned about the third axis as the periods before did."""
        with mp.workdps(DIGITS):
            n = int(mpf(t) / self.period)
            begun = mpf(t) - n * self.period
            A, B = (a * r**n for a, r in zip(self._parameters(begun), self.ratios, strict=True))
            w1, w2, w3 = self.motion.state(begun)[1]
            W = mpc(w2, w1) * (self.ratios[0] / self.ratios[1]) ** n
            q = product(conjugate(self.to_upright), (A.real, -B.imag, B.real, A.imag))
            return q, (W.imag, W.real, w3)


def upright(direction: Vector) -> Quaternion:
    """A rotation that takes a direction, not −z, to z."""
    length = mp.sqrt(dot(direction, direction))
    x, y, z = (c / length for c in direction)
    size = mp.sqrt(2 * (1 + z))
    return ((1 + z) / size, y / size, -x / size, mpf(0))
