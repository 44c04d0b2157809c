"""The reference: exact solutions and high-precision integration of a top's motion."""

from .facts import facts
from .flow import flow
from .invariants import drifts, invariants
from .sensitivity import Sensitivity, sensitivity
from .solution import Solution
from .solve import ExactMotion, solve, solve_cheaply, solve_ode
from .taylor import IntegrationError
