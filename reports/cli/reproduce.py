"""What the command `reproduce` writes: one run as a Python file that needs no spincheck."""

from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from ...engines import Engine, Method, engines
from ...reference import IntegrationError, Solution, solve
from ...scenarios import Scenario, printable
from ..harness.ladder import single
from .terminal import BAD_INPUT, NOT_RUN, Complaint

#: Times at which the file compares.
MOST_SAMPLES = 21

_HEAD = '''\
"""{title}

{engine} {engine_version}, {method}, a timestep of {timestep!r} s, against the exact motion: run it
with {engine} and numpy installed. Written by spincheck {version}.
"""

import numpy as np

TIMESTEP = {timestep!r}  # s


def product(q, r):
    """Of quaternions, w x y z."""
    vector = q[0] * r[1:] + r[0] * q[1:] + np.cross(q[1:], r[1:])
    return np.array([q[0] * r[0] - q[1:] @ r[1:], *vector])


def conjugate(q):
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def turned(q, v):
    return product(product(q, np.array([0.0, *v])), conjugate(q))[1:]


'''
_TAIL = """

# The exact motion, right to {omega:.1e} of the largest angular velocity and {attitude:.1e} rad
# ({solved}).
# Whole steps; attitude, w x y z, body to world; angular velocity, rad/s, body axes.
EXACT = [
{rows}
]
largest = {largest!r}  # rad/s
worst_omega = worst_attitude = taken = 0
print("      t, s   error of omega   error of attitude, rad")
for steps, q_exact, omega_exact in EXACT:
    if steps:
        step(steps - taken)
    taken = steps
    q, omega = state()
    off_omega = np.linalg.norm(omega - omega_exact) / largest
    apart = product(conjugate(q / np.linalg.norm(q)), np.array(q_exact))
    off_attitude = 2 * np.arctan2(np.linalg.norm(apart[1:]), abs(apart[0]))
    worst_omega, worst_attitude = max(worst_omega, off_omega), max(worst_attitude, off_attitude)
    print(f"{{steps * TIMESTEP:10.6g}}   {{off_omega:14.3e}}   {{off_attitude:22.3e}}")
print(f"largest      {{worst_omega:14.3e}}   {{worst_attitude:22.3e}}")
"""


def reproduction(scenario: Scenario, engine: Engine, method: Method, timestep: float) -> str:
    """The text of the Python file.

    Raises
    ------
    Complaint
        If the engine has no script, cannot simulate the scene with this method, or the exact motion
        is not known so far.
    """
    script = engine.script(scenario, method, timestep)
    if not script:
        raise Complaint(_without_script(scenario, engine), BAD_INPUT)
    if reason := engine.unsupported(scenario, method):
        raise Complaint(reason, BAD_INPUT)
    try:
        steps = single(timestep, scenario.times).sample_steps
    except ValueError as error:
        raise Complaint(f"'--timestep': {error}", BAD_INPUT) from None
    try:
        solution = solve(scenario, np.asarray(steps * timestep, dtype=float))
    except IntegrationError as error:
        raise Complaint(f"{scenario.name}: {error}", NOT_RUN) from None
    head = _HEAD.format(
        # The title goes into a docstring.
        title=printable(scenario.title).replace("\\", "/").replace('"', "'"),
        engine=engine.name.partition("@")[0],
        engine_version=engine.version,
        method=method.name,
        timestep=timestep,
        version=version("spincheck"),
    )
    return head + script + _tail(solution, steps)


def _without_script(scenario: Scenario, engine: Engine) -> str:
    """That an engine has none, and which have."""
    able = [one.name for one in engines().values() if one.script(scenario, one.methods[0], 1.0)]
    return (
        f"'--engine' must be one of {', '.join(able)}, which write scripts of themselves, "
        f"got '{engine.name}'"
    )


def _tail(solution: Solution, steps: NDArray[np.int64]) -> str:
    motion = solution.trajectory
    kept = np.unique(np.linspace(0, len(motion.t) - 1, MOST_SAMPLES).round().astype(int))
    columns = (steps, motion.q_world_body_wxyz, motion.omega_body)
    rows = zip(*(column[kept].tolist() for column in columns), strict=True)
    return _TAIL.format(
        largest=float(np.linalg.norm(motion.omega_body, axis=1).max()),
        solved=printable(solution.method),
        omega=solution.uncertainty.omega,
        attitude=solution.uncertainty.attitude,
        rows="\n".join(f"    ({step}, {q!r}, {omega!r})," for step, q, omega in rows),
    )
