"""Which closed form solves a problem."""

from .free_asymmetric import free_asymmetric
from .free_symmetric import free_symmetric
from .problem import Problem
from .symmetry import is_free, symmetry_axis
from .theta_quotients import ClosedForm

__all__ = ["ClosedForm", "closed_form"]


def closed_form(problem: Problem) -> ClosedForm | None:
    """The exact motion of a problem, None where no closed form covers it."""
    if is_free(problem):
        symmetric = symmetry_axis(problem) is not None or len({*problem.moments}) == 1
        return free_symmetric(problem) if symmetric else free_asymmetric(problem)
    return None
