"""Heavy symmetric tops: I1 = 1 kg m², lever on the third axis, gravity along −z."""

import numpy as np
from spincheck.reference.problem import Problem
from taylor_problems import problem

I3 = 0.5
UP, DOWN = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)


def tilted(beta: float) -> tuple[float, float, float, float]:
    """The attitude whose third axis is so far from the vertical, rad."""
    return (float(np.cos(beta / 2)), 0.0, float(np.sin(beta / 2)), 0.0)


def top(
    omega: tuple[float, float, float],
    q: tuple[float, float, float, float],
    I3: float = I3,
    kappa: float = 1.0,
) -> Problem:
    """A top with M g l = κ, N m."""
    return problem((1.0, 1.0, I3), omega, q, (0.0, 0.0, kappa), (0.0, 0.0, -1.0))
