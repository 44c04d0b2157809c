"""How a scene's body is drawn: a solid with its inertia, its axis, and the direction that is up."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from ....reference.rotational_problem import rotational_problem
from ....reference.symmetry import symmetry_axis
from ....scenarios import FloatArray, Scenario, Trajectory, angular_momentum_world
from ....scenarios.principal import principal_axes
from ...results.results import SceneResult
from ..analysis.report_data import SceneRuns

#: Number of samples of a path; least number of samples for each turn at the fastest rate.
MOST, A_TURN = 500, 24


@lru_cache(maxsize=1)
def dense_motion(scene: SceneRuns) -> Trajectory:
    """Return the exact motion at `MOST` evenly spread times.

    The times cover the window, or its first `MOST / A_TURN` turns if there are more.
    """
    shown = min(1.0, MOST / A_TURN / scene.turns) if scene.turns else 1.0
    return scene.outline(shown * scene.end, MOST)


#: The c in I₁ = m (h₂² + h₃²)/c, for a box of half sides h, and for an ellipsoid of semi-axes h.
BOX, ELLIPSOID = 3.0, 5.0
#: Least thickness of a flat body in pictures, as a fraction of its largest half side.
LEAST_THICKNESS = 0.03


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """The solid that stands for a body in pictures, and the directions that are drawn with it.

    Attributes
    ----------
    shape : an ellipsoid if two of the body's principal moments are equal, else a box
    half_sides : half sides, or semi-axes, of a solid with the body's mass and moments, along the
        principal axes, m, (3,)
    R_body_axes : matrix from components along the principal axes about the com to those along the
        body's axes, (3, 3)
    axis_body : unit vector of the axis whose path is drawn, body axes, (3,)
    up_world : unit vector from which the axis's tilt β is measured, world axes, (3,)
    up_means : the direction of `up_world` in words
    """

    shape: Literal["box", "ellipsoid"]
    half_sides: FloatArray
    R_body_axes: FloatArray
    axis_body: FloatArray
    up_world: FloatArray
    up_means: str


def drawn_body(solved: SceneResult) -> DrawnBody:
    """Return how a scene's body is drawn: its solid, its axis and the upward direction."""
    scenario = solved.scenario
    exact_moments, exact_axes = principal_axes(scenario.body.inertia_com_exact)
    moments = np.array(exact_moments, dtype=float)
    R_body_axes = np.array(exact_axes, dtype=float)
    first, second, third = np.sort(moments)
    symmetric = first == second or second == third
    up_world, up_means = _up(solved)
    return DrawnBody(
        "ellipsoid" if symmetric else "box",
        _half_sides(scenario.body.mass, moments, ELLIPSOID if symmetric else BOX),
        R_body_axes,
        axis_body(scenario),
        up_world,
        up_means,
    )


def axis_body(scenario: Scenario) -> FloatArray:
    """Return the unit vector, body axes, of the axis whose path is drawn, (3,).

    It points from the pivot, or from the tip on a table, to the com. For a free body, or if the com
    is the pivot, it is the symmetry axis; without one, the principal axis along which the component
    of the initial L is largest.
    """
    lever = scenario.constraint.lever
    length = float(np.linalg.norm(lever))
    if not scenario.constraint.is_free and length:
        return np.asarray(lever / length, dtype=float)
    problem = rotational_problem(scenario)
    moments, rates = np.array(problem.moments, float), np.array(problem.omega_axes, float)
    symmetric = symmetry_axis(problem)
    axis = np.eye(3)[int(np.argmax(np.abs(moments * rates)))]
    if symmetric is not None:
        axis = np.array(symmetric, dtype=float)
    _, R_body_axes = principal_axes(scenario.inertia_exact)
    return np.asarray(np.array(R_body_axes, dtype=float) @ axis)


def _up(solved: SceneResult) -> tuple[FloatArray, str]:
    """Return the upward direction, a unit vector in world axes, (3,), and its meaning in words.

    The direction is opposite to gravity if there is gravity and the body is on a pivot or a table.
    Otherwise it is that of the initial L, or the z axis if L is zero.
    """
    scenario = solved.scenario
    gravity = float(np.linalg.norm(scenario.gravity_world))
    if not scenario.constraint.is_free and gravity:
        return -scenario.gravity_world / gravity, "the upward vertical"
    L_world = angular_momentum_world(scenario, solved.solution.trajectory.until(1))[0]
    size = float(np.linalg.norm(L_world))
    if size:
        return np.asarray(L_world / size), "the initial angular momentum"
    return np.array([0.0, 0.0, 1.0]), "the z axis"


def _half_sides(mass: float, moments: FloatArray, shape: float) -> FloatArray:
    """Return the half sides of the solid, m, (3,): h₁² = (shape / 2 m) (I₂ + I₃ − I₁).

    A smaller half side is raised to `LEAST_THICKNESS` times the largest.

    Parameters
    ----------
    mass : m, kg
    moments : principal moments I, kg m², (3,)
    shape : `BOX` or `ELLIPSOID`
    """
    squares = shape / (2 * mass) * (moments.sum() - 2 * moments)
    half_sides = np.sqrt(np.maximum(squares, 0.0))
    return np.asarray(np.maximum(half_sides, LEAST_THICKNESS * half_sides.max()))
