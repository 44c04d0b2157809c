"""Poses a scenario as an initial value problem about its fixed point, in principal axes."""

from mpmath import mp, mpf

from ..scenarios import Scenario
from ..scenarios.exact import DIGITS, ZERO, Vector, conjugate, product, rotate, vector
from ..scenarios.principal import from_matrix, principal_axes
from .problem import Problem


def rotational_problem(scenario: Scenario) -> Problem:
    """The rotational problem of a scene: about its pivot, or else its centre of mass.

    Nothing is rounded: every double of the file is taken exactly.
    """
    body, start = scenario.body, scenario.start
    tensor = body.inertia_origin_exact if scenario.has_pivot else body.inertia_com_exact
    with mp.workdps(DIGITS):
        moments, R_body_axes = principal_axes(tensor)
        q_axes_body = conjugate(from_matrix(R_body_axes))
        return Problem(
            moments=moments,
            q_world_axes=product(start.q_exact, conjugate(q_axes_body)),
            omega_axes=rotate(q_axes_body, start.omega_body_exact),
            lever_axes=rotate(q_axes_body, _lever_body(scenario)),
            gravity_world=vector(scenario.gravity_world),
            torque_axes=rotate(q_axes_body, vector(scenario.torque_body)),
            torque_world=vector(scenario.torque_world),
            drag=mpf(scenario.drag),
            q_axes_body=q_axes_body,
        )


def _lever_body(scenario: Scenario) -> Vector:
    """Mass times com, kg m, where gravity has a pivot to pull about."""
    if not {"pivot", "gravity"} <= scenario.called_for:
        return ZERO
    x, y, z = scenario.body.com_exact
    mass = scenario.body.mass_exact
    return (mass * x, mass * y, mass * z)
