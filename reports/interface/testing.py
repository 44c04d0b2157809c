"""Assertions for tests, in the manner of `numpy.testing`."""

import math
from typing import TYPE_CHECKING

import numpy as np
from spincheck import judge
from spincheck.scenarios import SIGNAL

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from spincheck import Scene

__all__ = ["assert_matches_exact"]


def assert_matches_exact(
    scene: "Scene",
    *,
    t: "ArrayLike",
    q_wxyz: "ArrayLike | None" = None,
    q_xyzw: "ArrayLike | None" = None,
    omega_body: "ArrayLike | None" = None,
    omega_world: "ArrayLike | None" = None,
    com: "ArrayLike | None" = None,
    velocity: "ArrayLike | None" = None,
    spins: "ArrayLike | None" = None,
    **bounds: float,
) -> None:
    """Raise `AssertionError` if a motion is further from the exact one than bounds allow.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`
    t, q_wxyz, q_xyzw, omega_body, omega_world, com, velocity, spins : the motion, in the arrays
        that `spincheck.judge` takes
    bounds : the largest error allowed in each signal that is to be checked, at least one:
        `attitude`, rad; `omega`, `angular_momentum` and `energy`, relative; `com_error`,
        `velocity_error` and `spins_error`, relative, for the signals com, velocity and spins

    Raises
    ------
    AssertionError
        Its message names each signal that exceeds its bound, by how much, and from when on. It
        names the common mistake that explains the errors, if there is one.
    ValueError
        If no bound is given; if a bound is not a positive number, names no signal, or names one
        that was not recorded; or if the arrays cannot be judged (`spincheck.judge`).
    """
    wanted = {name.removesuffix("_error"): bound for name, bound in bounds.items()}
    if unknown := [name for name in wanted if name not in SIGNAL]:
        raise ValueError(f"'{unknown[0]}' must be one of {', '.join(SIGNAL)}.")
    if not wanted:
        raise ValueError("a bound must be given, such as attitude=1e-3.")
    for name, bound in bounds.items():
        if not (isinstance(bound, int | float | np.floating) and 0 < bound < math.inf):
            raise ValueError(f"'{name}' must be a positive number, got {bound!r}.")
    motion = judge(
        scene,
        t=t,
        q_wxyz=q_wxyz,
        q_xyzw=q_xyzw,
        omega_body=omega_body,
        omega_world=omega_world,
        com=com,
        velocity=velocity,
        spins=spins,
    )
    if beyond := motion.beyond(wanted):
        explained = [f"Explained by: {words}." for words in motion.explained_by]
        lines = ["The motion is not the exact one:", *beyond, *explained]
        raise AssertionError("\n".join(lines))
