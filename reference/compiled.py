"""Compiles kernels and keeps their machine code on disk, so that solving a scene only loads it.

These are all kernels except those of sensitivities, which are compiled at their first call.

`reports/harness/executors/compiling.py` compiles them in processes side by side.
"""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from ..scenarios import Scenario, loads
from .deviations import apart
from .flow import flow
from .following import follow, rates
from .kernel import FOLDER
from .other_equations import equations_of
from .solve import ExactMotion, solve_ode

#: Name of the empty file that says that the folder of machine code is complete.
COMPLETE = "complete"
#: A free body and a heavy top; each is solved in closed form and, for comparison, as an ODE.
_SCENES = {
    "free": "\n[effects]\n",
    "heavy": "\n[effects.gravity]\nacceleration = [0.0, 0.0, -9.81]\n[effects.pivot]\n",
}
_TEXT = """spincheck = 1
title = "Compiled with"
source = "none"
[body]
mass = 1.0
inertia = [2.0, {I2}, 3.0]
com = [0.0, 0.0, 0.1]
[start]
euler_zyz_deg = [0.0, 30.0, 0.0]
omega_body = [0.1, 0.2, 3.0]
[window]
duration = 0.1
samples = 2
"""
_I2 = {"free": 2.5, "heavy": 2.0}


def is_compiled() -> bool:
    """Whether the machine code of all functions that `compile_kernels` compiles is on disk."""
    return FOLDER is not None and (FOLDER / COMPLETE).exists()


def compile_march() -> None:
    """Compile the numba kernels of the ODE integrator, in half the time of `compile_kernels`."""
    for scenario in _scenes():
        solve_ode(scenario, scenario.times)


def compile_flow() -> None:
    """Compile the numba kernels of closed forms and of `flow`, `following` and `deviations`."""
    for scenario in _scenes():
        exact = ExactMotion(scenario).outline(scenario.times)
        flow(scenario, exact, np.zeros(len(exact.t)))
        states = np.hstack([exact.q_world_body_wxyz, exact.omega_body])
        equations = equations_of(scenario)
        apart(follow(equations, states, np.zeros((len(states), 1)))[:, 0], states)
        rates(equations, states, np.zeros((len(states), 3)))


def compile_kernels() -> None:
    """Call each numba kernel once, except those of sensitivities: numba compiles or loads it then.

    An empty file, `COMPLETE`, then marks the folder of machine code as complete, if that folder
    can be written.
    """
    compile_march()
    compile_flow()
    if FOLDER is not None:
        # On a full disk the next process compiles again.
        with suppress(OSError):
            (FOLDER / COMPLETE).touch()


def _scenes() -> Iterator[Scenario]:
    for name, effects in _SCENES.items():
        yield loads(_TEXT.format(I2=_I2[name]) + effects, name)
