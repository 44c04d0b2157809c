"""Made-up curves whose errors follow a law, so that all costs on them are known."""

from collections.abc import Callable
from dataclasses import replace

from spincheck.reports.pages.analysis.work_precision import EPS, Curve, CurvePoint

#: A power and a quotient of logarithms, each good to a few ulp of numbers up to some tens.
ROUNDING = 64 * EPS
#: s
COARSEST = 0.01
RUNGS = 6
#: Asymptotic, as errors go.
COARSEST_ERROR = 0.05


def law(order: float, error: float = COARSEST_ERROR) -> Callable[[float], float]:
    """Error of a timestep: `error` at the coarsest, a power below."""
    return lambda timestep: error * (timestep / COARSEST) ** order


def curve_of_law(
    error: Callable[[float], float], seconds: float | None = 1e-6, **facts: object
) -> Curve:
    """A converging method with that error on every rung."""
    timesteps = [COARSEST / 2**k for k in range(RUNGS)]
    points = tuple(CurvePoint(dt, seconds and seconds / dt, error(dt)) for dt in timesteps)
    curve = Curve(
        engine="made-up",
        method="law",
        signal="omega",
        points=points,
        stable=points,
        seconds_per_step=seconds,
        uncertainty=EPS,
        rounding=0.0,
        duration=1.0,
        single_precision=False,
        declared=1,
        verdict="converges",
        reason="order as declared",
        order=None,
    )
    return replace(curve, **facts)


def curve_of_errors(*errors: float, **facts: object) -> Curve:
    """The same with its errors listed, coarse to fine."""
    errors_at = {COARSEST / 2**k: error for k, error in enumerate(errors)}
    points = tuple(CurvePoint(dt, 1e-6 / dt, error) for dt, error in errors_at.items())
    return curve_of_law(law(1), points=points, stable=points, **facts)
