"""Poses a scenario as an initial value problem about its fixed point, in principal axes."""

from typing import Any

from mpmath import mp

from ..scenarios import Scenario
from ..scenarios.exact import DIGITS, conjugate, product, rotate
from ..scenarios.principal import from_matrix, principal_axes
from .effect_terms import TERMS
from .motion import FORCES_IN_FLIGHT
from .problem import Problem


def rotational_problem(scenario: Scenario) -> Problem:
    """Return the rotational problem of a scene about its pivot, or else its centre of mass.

    No number is rounded: every double in the scene's file is taken exactly.

    Raises
    ------
    NotImplementedError
        If the scene has an effect that `effect_terms` does not know, or a force that `motion` does
        not know.
    """
    forces = {effect.name for effect in scenario.acting if effect.is_force} - FORCES_IN_FLIGHT
    if unknown := scenario.called_for - TERMS.keys() - {"pivot"} | forces:
        names = ", ".join(sorted(unknown))
        raise NotImplementedError(
            f"the exact motion with {names} is unknown: see docs/how-to/add-an-effect.md"
        )
    start = scenario.start
    with mp.workdps(DIGITS):
        moments, R_body_axes = principal_axes(scenario.inertia_exact)
        q_axes_body = conjugate(from_matrix(R_body_axes))
        posed: dict[str, Any] = {}
        for terms in TERMS.values():
            posed |= terms.posed(scenario, q_axes_body)
        return Problem(
            moments=moments,
            q_world_axes=product(start.q_exact, conjugate(q_axes_body)),
            omega_axes=rotate(q_axes_body, start.omega_body_exact),
            q_axes_body=q_axes_body,
            **posed,
        )
