"""Exudyn's solvers and what is set of them, by the names of its `timeIntegration` settings."""

AS_SHIPPED = "GeneralizedAlpha"
#: Integrators that solve for accelerations at the end of a step.
IMPLICIT = frozenset({AS_SHIPPED, "TrapezoidalIndex2"})
#: Tolerances, relative and in units of the residual; Exudyn's defaults are 1e-8 and 1e-10.
NEWTON_TOLERANCE = 1e-13
_OF_TRAPEZOIDAL_RULE: dict[str, bool | float] = {
    # As Exudyn's own SolveDynamic sets them for this solver name.
    "generalizedAlpha.useIndex2Constraints": True,
    "generalizedAlpha.useNewmark": True,
    # Solved to round-off, with a new Jacobian: so a step depends on the state alone.
    "newton.relativeTolerance": NEWTON_TOLERANCE,
    "newton.absoluteTolerance": NEWTON_TOLERANCE,
    "newton.useModifiedNewton": False,
}


def main_solver(solver: str) -> str:
    """The name of the class that runs it."""
    return "MainSolverImplicitSecondOrder" if solver in IMPLICIT else "MainSolverExplicit"


def solver_settings(solver: str) -> dict[str, bool | float]:
    """What differs from the defaults, besides the type of the solver."""
    own = _OF_TRAPEZOIDAL_RULE if solver == "TrapezoidalIndex2" else {}
    # A default that halves steps if the solver fails.
    steady: dict[str, bool | float] = {} if solver == AS_SHIPPED else {"adaptiveStep": False}
    return own | steady
