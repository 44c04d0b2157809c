"""Kinds of motion: what turns the body, and whether it has an axis of symmetry."""

from ..scenarios import Scenario
from .effect_terms import is_free, is_undriven
from .rotational_problem import rotational_problem
from .symmetry import equal, symmetry_axis

#: The kinds, in the order in which they are shown.
KINDS = (
    "free symmetric",
    "free asymmetric",
    "heavy symmetric",
    "heavy asymmetric",
    "with other effects",
)


def kind_of(scenario: Scenario) -> str:
    """Return the kind of a scene's motion, one of `KINDS`.

    The motion is free if nothing turns the body, and heavy if gravity alone does. It is "with other
    effects" if anything else turns the body, or if its rotors have an angular momentum.
    """
    problem = rotational_problem(scenario)
    if not is_undriven(problem):
        return "with other effects"
    least, _, largest = sorted(problem.moments)
    is_symmetric = symmetry_axis(problem) is not None or equal(least, largest)
    weight = "free" if is_free(problem) else "heavy"
    return f"{weight} {'symmetric' if is_symmetric else 'asymmetric'}"
