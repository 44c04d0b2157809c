"""Kinds of motion: what turns the body, and whether it has an axis of symmetry."""

from ..scenarios import Scenario
from .effect_terms import is_free, is_undriven
from .rotational_problem import rotational_problem
from .symmetry import equal, symmetry_axis

#: In the order in which they are shown.
KINDS = (
    "free symmetric",
    "free asymmetric",
    "heavy symmetric",
    "heavy asymmetric",
    "with other effects",
)


def kind_of(scenario: Scenario) -> str:
    """One of `KINDS`: no torque, or gravity's alone, turns a body that is free, or heavy."""
    problem = rotational_problem(scenario)
    if not is_undriven(problem):
        return "with other effects"
    least, _, largest = sorted(problem.moments)
    is_symmetric = symmetry_axis(problem) is not None or equal(least, largest)
    weight = "free" if is_free(problem) else "heavy"
    return f"{weight} {'symmetric' if is_symmetric else 'asymmetric'}"
