"""Which closed form solves a problem."""

from .effect_terms import is_free, is_undriven
from .free_asymmetric import free_asymmetric
from .free_symmetric import free_symmetric
from .lagrange import lagrange
from .problem import Problem
from .symmetry import equal, symmetry_axis
from .theta_quotients import ClosedForm

__all__ = ["ClosedForm", "closed_form"]


def closed_form(problem: Problem) -> ClosedForm | None:
    """Return the exact motion of a problem in closed form; None if no closed form covers it."""
    symmetric = symmetry_axis(problem) is not None
    if is_free(problem):
        sphere = equal(min(problem.moments), max(problem.moments))
        return free_symmetric(problem) if symmetric or sphere else free_asymmetric(problem)
    return lagrange(problem) if symmetric and is_undriven(problem) else None
