"""The lines drawn on a method's map: stability limits from theory, and the stock timestep."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ....engines import Method
from ....reference.stability_bounds import (
    COARSE_TURN,
    LEAPFROG_LIMIT,
    RK4_LIMIT,
    StabilityNumbers,
    euler_folds,
    rk4_folds,
)
from ..analysis.wording import duration

#: Replaces a rate of zero before a logarithm is taken: no timestep reaches a limit then.
LEAST = 1e-300


@dataclass(frozen=True)
class Bound:
    """One line.

    Attributes
    ----------
    label : a word beside it
    meaning : what is on either side
    source : of the formula
    value : function of the scene's numbers and the timestep, s: zero on the line, NaN if undefined
    dash : how it is drawn, by Plotly's names
    """

    label: str
    meaning: str
    source: str
    value: Callable[[StabilityNumbers, float], float]
    dash: str


_STABILITY = "Hairer & Wanner, Solving Ordinary Differential Equations II, §IV.2"
TURN = Bound(
    f"{COARSE_TURN:g} rad",
    f"‖ω‖ dt = {COARSE_TURN:g} rad: a step turns the body this far",
    "a turn seen a few times only is not resolved",
    lambda n, dt: _log(n.turning * dt / COARSE_TURN),
    "dot",
)
EULER = Bound(
    "e-fold",
    "first order: within the window free precession grows (explicit) or dies away (implicit) by a "
    "factor of e; by more at longer timesteps",
    f"|R(iλ dt)| = √(1 + λ² dt²) a step; {_STABILITY}",
    lambda n, dt: _log(euler_folds(n.gyration, dt, n.duration)),
    "dash",
)
RK4_DAMPING = Bound(
    "e-fold",
    "fourth order: within the window free precession dies away by a factor of e; by more at longer "
    "timesteps",
    f"|R(iλ dt)| of the classical Runge–Kutta method; {_STABILITY}",
    lambda n, dt: _log(rk4_folds(n.gyration, dt, n.duration)),
    "dash",
)
SWING = Bound(
    "swing 2",
    "first order: small swings about hanging at rest are bounded up to rate × dt = 2",
    "Hairer, Lubich & Wanner, Geometric Numerical Integration, ch. XIII",
    lambda n, dt: _log(n.swinging * dt / LEAPFROG_LIMIT),
    "longdash",
)
RK4_BLOWS_UP = Bound(
    "2√2",
    "fourth order: free precession, or small swings, grow in every step from rate × dt = 2√2 on",
    _STABILITY,
    lambda n, dt: _log(max(n.gyration, n.swinging) * dt / RK4_LIMIT),
    "solid",
)
SLEEPING = Bound(
    "sleeps",
    "p_γ² = 4 M g l I₁: an upright top with more spin stays up",
    "Arnold, Mathematical Methods of Classical Mechanics, §31",
    lambda n, _: math.nan if n.sleeping is None else _log(n.sleeping),
    "dashdot",
)
SEPARATRIX = Bound(
    "separatrix",
    "2 T I₂ = L², I₂ the middle moment: ω goes round another axis on the other side",
    "Landau & Lifshitz, Mechanics, §37",
    lambda n, _: math.nan if n.separatrix is None else n.separatrix,
    "dashdot",
)

#: How far a body may turn in a step before its engine clamps the turn, where that is π over this.
_PI_OVER = range(1, 9)


def bounds_of(method: Method | None, stock_timestep: float | None = None) -> tuple[Bound, ...]:
    """The lines that apply to a method; if its order is unknown, only those of the scene.

    Parameters
    ----------
    stock_timestep : s, of its engine; None if it has none
    """
    at_stock = (stock(stock_timestep),) if stock_timestep else ()
    if method is None:
        return TURN, SLEEPING, SEPARATRIX
    turn = TURN if math.isinf(method.max_rotation_per_step) else clamp(method.max_rotation_per_step)
    by_order = {1: (EULER, SWING), 4: (RK4_DAMPING, RK4_BLOWS_UP)}
    return turn, *at_stock, *by_order.get(method.order, ()), SLEEPING, SEPARATRIX


def stock(timestep: float) -> Bound:
    """The line of the engine's stock timestep, s."""
    timestep_text = duration(timestep)
    return Bound(
        f"stock {timestep_text}",
        f"dt = {timestep_text}: the engine's default timestep",
        "as its adapter declares",
        lambda _, dt: _log(dt / timestep),
        "longdashdot",
    )


def clamp(most: float) -> Bound:
    """The line where an engine limits the turn of a step to `most` rad."""
    parts = [k for k in _PI_OVER if math.isclose(math.pi / k, most)]
    angle_text = f"π/{parts[0]}" if parts else f"{most:.3g} rad"
    return Bound(
        angle_text,
        f"‖ω‖ dt = {angle_text}: beyond it the engine cuts the turn of a step short",
        "as its adapter declares",
        lambda n, dt: _log(n.turning * dt / most),
        "solid",
    )


def _log(ratio: float) -> float:
    return math.log(max(ratio, LEAST))
