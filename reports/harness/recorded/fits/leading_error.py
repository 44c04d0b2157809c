"""The leading term of the error of an unknown one-step method, of which only the order is known.

In a step h the leading error of a method of order p is h^(p+1) times a combination of the
elementary differentials of order p + 1, one for each rooted tree with p + 1 vertices (Hairer,
Lubich & Wanner, Geometric Numerical Integration, §III.1). A method that treats attitude and ω
differently, such as semi-implicit Euler, has one for each way to colour the vertices of these trees
(§III.2). Elementary differentials depend on the variables: those of a method that computes with ω
along world axes, as Drake and PyBullet do, are others than those of ω along body axes. Over many
steps these errors add up, carried along by the exact flow. The coefficients of the combination are
about one at most: explicit Euler's is ½, and those of methods of higher orders are smaller
(§III.1.3).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import lsq_linear

from .....reference.deviations import apart
from .....reference.following import follow, rates
from .....reference.other_equations import OtherEquations
from .....scenarios import FloatArray
from .....scenarios.rotation import cross, matrices, norms, turned, turned_back, turning_of
from ..samples.intervals import Intervals

#: Order up to which vertices of trees are coloured: for higher orders there are too many trees.
COLOURED = 2
#: Number of nodes of the quadrature along an interval. Differences of states, relative to their
#: sizes, by which derivatives are taken, and by which errors are carried along the exact flow.
NODES, SMALL, CARRIED = 3, 1e-3, 1e-4
#: Largest coefficient of an elementary differential.
LARGEST = 2.0
#: Methods are taken to compute with ω along world axes only if their errors leave less than this
#: fraction of what errors of methods with ω along body axes leave, as a root mean square.
WORLD = 0.5
#: Colours of the vertices of rooted trees. A vertex stands for the right-hand sides of both the
#: attitude's equation and Euler's equations, or of either alone. With a colour from `TERMS` on it
#: stands for one term of Euler's equations.
BOTH, ATTITUDE, OMEGA, TERMS = 0, 1, 2, 3
#: For each term of Euler's equations, which a method may treat by itself: the names in
#: `OtherEquations` of its coefficients.
_TERMS = (
    ("gyroscopic", "kept"),
    ("pull",),
    ("torque", "torque_world"),
    ("slowing", "damping", "friction", "turned_drag"),
    ("attitude_torque", "spring", "gravity_gradient"),
)

#: A rooted tree: the colour of its root, and the subtrees that are attached to the root.
Tree = tuple[int, tuple["Tree", ...]]


def left_by_methods(
    data: Intervals, orders: Sequence[int], timestep: float | None = None
) -> FloatArray:
    """Return what fitted leading errors of methods leave of the deviations in S intervals, (6 S,).

    The deviations are those of the recorded ends from the flow of `data.base`, in units of
    `data.scale`. The errors are combinations of elementary differentials. Their coefficients, at
    most `LARGEST` in size, are fitted by least squares.

    Parameters
    ----------
    data : the S intervals, and in `data.base` the equations that the methods solve
    orders : orders of accuracy of the methods
    timestep : timestep of the methods, s; the time between samples if None
    """
    return _fitted(data, orders, timestep)[1]


def leading_errors(
    data: Intervals, orders: Sequence[int], timestep: float | None = None
) -> FloatArray:
    """Return the errors at the ends of S intervals by each elementary differential, (k, S, 6).

    They are errors of attitude, rad, and ω, rad/s, that grow from 0 at the start of an interval,
    by each of the k differentials with a coefficient of one. The differentials are those of methods
    that compute with ω along body axes; if those of methods with ω along world axes leave less than
    the fraction `WORLD` of the deviations that they leave, these are returned. If ω was computed
    from attitudes, its errors at the start and at the end of an interval are included.

    Parameters
    ----------
    data : the S intervals, and in `data.base` the equations that the methods solve
    orders : orders of accuracy of the methods
    timestep : timestep of the methods, s; the time between samples if None
    """
    return _fitted(data, orders, timestep)[0]


def _fitted(
    data: Intervals, orders: Sequence[int], timestep: float | None
) -> tuple[FloatArray, FloatArray]:
    """Return the errors of `leading_errors`, and the residuals of `left_by_methods`."""
    of_body, of_world = (
        _errors(data, orders, timestep, is_world=is_world) for is_world in (False, True)
    )
    left, left_in_world = (_left(data, errors) for errors in (of_body, of_world))
    if np.linalg.norm(left_in_world) < WORLD * np.linalg.norm(left):
        return of_world, left_in_world
    return of_body, left


def _left(data: Intervals, errors: FloatArray) -> FloatArray:
    """Return what a fit of methods' errors, (k, S, 6), leaves of the deviations, (6 S,)."""
    residuals = data.deviations(data.base[None]).ravel()
    columns = (errors / data.scale).reshape(len(errors), -1).T
    # Columns are scaled to length 1, so that none is too small to count.
    units = np.linalg.norm(columns, axis=0)
    columns = columns[:, units > 0] / units[units > 0]
    best = lsq_linear(columns, residuals, (-LARGEST * units[units > 0], LARGEST * units[units > 0]))
    return np.asarray(residuals - columns @ best.x)


def _errors(
    data: Intervals, orders: Sequence[int], timestep: float | None, *, is_world: bool
) -> FloatArray:
    """Return the errors of `leading_errors` of methods with given variables, (k, S, 6).

    Parameters
    ----------
    is_world : whether the methods compute with ω along world axes, and not along body axes
    """
    steps = np.minimum(timestep or np.inf, data.spans)
    equations = data.base
    rate = max(float(norms(data.starts[:, 4:]).max()), float(equations.rate))
    units = np.array([1.0, rate]).repeat([4, 3])
    terms = _terms(equations)
    # In units in which `rate` is 1, the error is a power of the timestep. It is divided by
    # `CARRIED`, by which differentials are multiplied before the flow carries them along.
    every, sizes = list[Tree](), []
    for order in orders:
        more = trees(order + 1, _colours(order, len(terms)))
        every += more
        sizes += len(more) * [(rate * steps) ** order / CARRIED]
    errors = np.zeros((len(every), *data.scale.shape))
    coloured = *[equations] * TERMS, *terms
    nodes, weights = leggauss(NODES)
    for part, weight in zip((1 + nodes) / 2, weights / 2, strict=True):
        here = follow(equations, data.starts, part * data.spans)[:, 0]
        remaining = (1 - part) * data.spans
        ends = follow(equations, here, remaining)[:, 0]
        differentials = _Differentials(coloured, here, rate, is_world)
        for error, tree, size in zip(errors, every, sizes, strict=True):
            moved = here + CARRIED * units * differentials.of(tree)
            moved[:, :4] /= norms(moved[:, :4])[:, None]
            carried = apart(ends, follow(equations, moved, remaining)[:, 0])
            error += weight * data.spans * rate * size * carried
    # An ω that is computed from attitudes is the rate at which they turn, errors included. It
    # differs from the method's ω by the part of the differential that acts on the attitude.
    if data.is_derived:
        ends = follow(equations, data.starts, data.spans)[:, 0]
        both = [_Differentials(coloured, at, rate, is_world) for at in (data.starts, ends)]
        for error, tree, size in zip(errors, every, sizes, strict=True):
            began, ended = (
                CARRIED * rate * turning_of(one.states[:, :4], one.of(tree)[:, :4]) for one in both
            )
            moved = data.starts + np.hstack([np.zeros_like(began[:, :1]), 0 * began, began])
            error -= size * apart(ends, follow(equations, moved, data.spans)[:, 0])
            error[:, 3:] += size * ended
    return errors


def _terms(equations: OtherEquations) -> list[OtherEquations]:
    """Return, for each nonzero term of Euler's equations, equations of motion with it alone."""
    every = {name: 0 * getattr(equations, name) for names in _TERMS for name in names}
    acting = [[n for n in names if getattr(equations, n).any()] for names in _TERMS]
    return [
        equations.of(**every | {name: getattr(equations, name) for name in names})
        for names in acting
        if names
    ]


def _colours(order: int, terms: int) -> Sequence[int]:
    """Return the colours of rooted trees' vertices for methods of an order of accuracy.

    A colour says for which right-hand side a vertex stands: that of all equations, of the
    attitude's equation, of Euler's equations, or of one term of Euler's equations.

    Parameters
    ----------
    terms : the number of nonzero terms of Euler's equations
    """
    if order > COLOURED:
        return [BOTH]
    return [ATTITUDE, *range(TERMS, TERMS + terms)] if order == 1 else [ATTITUDE, OMEGA]


def trees(count: int, colours: Sequence[int]) -> list[Tree]:
    """Return all rooted trees with `count` vertices, each vertex of one of the given colours."""
    return [(root, branches) for root in colours for branches in _forests(count - 1, colours)]


def _forests(count: int, colours: Sequence[int]) -> list[tuple[Tree, ...]]:
    """Return all forests, which are multisets of rooted trees, with `count` vertices in total.

    Each vertex has one of the given colours.
    """
    if not count:
        return [()]
    forests = {
        tuple(sorted((tree, *others)))
        for first in range(1, count + 1)
        for tree in trees(first, colours)
        for others in _forests(count - first, colours)
    }
    return sorted(forests)


@dataclass(frozen=True, eq=False)
class _Differentials:
    """The elementary differentials of equations of motion, at n states.

    Attributes
    ----------
    equations : the equations that vertices of each colour stand for, by the colour's number
    states : q, scalar first, and ω, rad/s, body axes, (n, 7)
    rate : the fastest rate at which states change, 1/s
    is_world : whether the variables of the method are q and ω along world axes, and not along body
        axes
    """

    equations: Sequence[OtherEquations]
    states: FloatArray
    rate: float
    is_world: bool = False

    def of(self, tree: Tree) -> FloatArray:
        """Return a tree's elementary differential, changes of q and of ω in body axes, (n, 7).

        The unit of time is 1/`rate`.
        """
        if not self.is_world:
            return self._of(tree, self.states)
        R, omega = matrices(self.states[:, :4]), self.states[:, 4:]
        change = self._of(tree, np.hstack([self.states[:, :4], turned(R, omega)]))
        # ω along body axes changes, too, as the attitude does: Rᵀ dω − dφ × Rᵀ ω.
        turn = turning_of(self.states[:, :4], change[:, :4])
        of_omega = turned_back(R, change[:, 4:]) - cross(turn, omega / self.rate)
        return np.hstack([change[:, :4], of_omega])

    def _of(self, tree: Tree, states: FloatArray) -> FloatArray:
        """Return a tree's elementary differential in the variables of n given states, (n, 7).

        With m subtrees at the root it is the m-th derivative of the right-hand side that the root
        stands for, in the directions of the subtrees' differentials. Derivatives are taken by
        central differences.

        Parameters
        ----------
        states : q, scalar first, and ω, rad/s, (n, 7); ω is along the axes that `is_world` says
        """
        root, branches = tree
        directions = [self._of(one, states) for one in branches]
        slopes = self._slopes_in_world if self.is_world else self._slopes
        units = np.array([1.0, self.rate]).repeat([4, 3])
        total = np.zeros_like(states)
        for signs in product((1, -1), repeat=len(branches)):
            moved = states + SMALL * units * sum(
                sign * one for sign, one in zip(signs, directions, strict=True)
            )
            total += np.prod(signs) * slopes(root, moved)
        total /= (2 * SMALL) ** len(branches) * self.rate * units
        is_kept = np.repeat([root <= ATTITUDE, root != ATTITUDE], [4, 3])
        return np.where(is_kept, total, 0.0)

    def _slopes_in_world(self, colour: int, states: FloatArray) -> FloatArray:
        """Return q' and ω' of n states by the equations that a colour stands for, (n, 7).

        In the states and in the result, ω and ω' are along world axes. As ω × ω is zero, ω' along
        world axes is ω' along body axes, turned.
        """
        q = states[:, :4]
        R = matrices(q / norms(q)[:, None])
        slopes = self._slopes(colour, np.hstack([q, turned_back(R, states[:, 4:])]))
        return np.hstack([slopes[:, :4], turned(R, slopes[:, 4:])])

    def _slopes(self, colour: int, states: FloatArray) -> FloatArray:
        """Return q' and ω' of n states by the equations that a colour stands for, (n, 7).

        ω and ω' are along body axes. The quaternions of the states may have any length.
        """
        equations = self.equations[colour]
        kept = np.repeat(equations.kept[None], len(states), axis=0)
        turning, accelerated = np.split(rates(equations, states, kept), 2, axis=1)
        w, v = states[:, :1], states[:, 1:4]
        along = np.sum(v * turning, axis=1, keepdims=True)
        return np.hstack([-along / 2, (w * turning + cross(v, turning)) / 2, accelerated])
