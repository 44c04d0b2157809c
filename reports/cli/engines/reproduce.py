"""The command `reproduce`: writes one run as a file that does not need spincheck."""

from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from ....engines import Engine, EngineError, Method, engines
from ....reference import Solution
from ....scenarios import Scenario, printable
from ...harness.timesteps.ladder import single
from ..scenes.exact_motion import solved
from ..terminal import NOT_RUN, Complaint, as_complaint

_PYTHON_HEAD = '''\
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
_PYTHON_TAIL = """

# The exact motion, right to {omega:.1e} of the largest angular velocity and {attitude:.1e} rad
# ({solved}).
# Whole steps; attitude, w x y z, body to world; angular velocity, rad/s, body axes.
EXACT = [
{rows}
]
LARGEST = {largest!r}  # rad/s; errors of omega are relative to it


def main():
    worst_omega = worst_attitude = taken = 0
    print("      t, s   error of omega   error of attitude, rad")
    for steps, q_exact, omega_exact in EXACT:
        if steps:
            step(steps - taken)
        taken = steps
        q, omega = state()
        off_omega = np.linalg.norm(omega - omega_exact) / LARGEST
        apart = product(conjugate(q / np.linalg.norm(q)), np.array(q_exact))
        off_attitude = 2 * np.arctan2(np.linalg.norm(apart[1:]), abs(apart[0]))
        worst_omega = np.maximum(worst_omega, off_omega)
        worst_attitude = np.maximum(worst_attitude, off_attitude)
        print(f"{{steps * TIMESTEP:10.6g}}   {{off_omega:14.3e}}   {{off_attitude:22.3e}}")
    print(f"largest      {{worst_omega:14.3e}}   {{worst_attitude:22.3e}}")


main()
"""
_JAVASCRIPT_HEAD = """\
// {title}
// {engine} {engine_version}, {method}, a timestep of {timestep!r} s, against the exact motion.
// Written by spincheck {version}.
const TIMESTEP = {timestep!r};  // s

"""
_JAVASCRIPT_TAIL = """
// Of quaternions, w x y z.
function product([w, x, y, z], [a, b, c, d]) {{
  return [w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c,
    w * c - x * d + y * a + z * b, w * d + x * c - y * b + z * a];
}}

function conjugate([w, x, y, z]) {{
  return [w, -x, -y, -z];
}}

function turned(q, v) {{
  return product(product(q, [0, ...v]), conjugate(q)).slice(1);
}}

// The exact motion, right to {omega:.1e} of the largest angular velocity and {attitude:.1e} rad
// ({solved}).
// Whole steps; attitude, w x y z, body to world; angular velocity, rad/s, body axes.
const EXACT = [
{rows}
];
const LARGEST = {largest!r};  // rad/s; errors of omega are relative to it

function row(t, ...errors) {{
  const padded = ([x, width]) => {{
    const twoDigits = (_, sign, digit) => `e${{sign}}0${{digit}}`;
    return x.toExponential(3).replace(/e([+-])(\\d)$/, twoDigits).padStart(width);
  }};
  console.log([t.padStart(10), ...errors.map(padded)].join('   '));
}}

function main() {{
  let worstOmega = 0, worstAttitude = 0, taken = 0;
  console.log('      t, s   error of omega   error of attitude, rad');
  for (const [steps, qExact, omegaExact] of EXACT) {{
    if (steps) step(steps - taken);
    taken = steps;
    const [q, omega] = state();
    const offOmega = Math.hypot(...omega.map((x, i) => x - omegaExact[i])) / LARGEST;
    const [w, ...apart] = product(conjugate(q), qExact);
    const offAttitude = 2 * Math.atan2(Math.hypot(...apart), Math.abs(w));
    worstOmega = Math.max(worstOmega, offOmega);
    worstAttitude = Math.max(worstAttitude, offAttitude);
    row(String(Number((steps * TIMESTEP).toPrecision(6))), [offOmega, 14], [offAttitude, 22]);
  }}
  row('largest   ', [worstOmega, 14], [worstAttitude, 22]);
}}

main();
"""


@dataclass(frozen=True)
class Frame:
    """The text around an engine's script, in one language.

    Attributes
    ----------
    suffix : ending of the file's name
    head, tail : templates of the text before and after the script; the head contains a title
    row : template of a line of exact values: number of steps; attitude, quaternion w x y z; ω,
        rad/s, body axes
    """

    suffix: str
    head: str
    tail: str
    row: str


FRAMES = {
    "Python": Frame(".py", _PYTHON_HEAD, _PYTHON_TAIL, "    ({}, {!r}, {!r}),"),
    "JavaScript": Frame(".mjs", _JAVASCRIPT_HEAD, _JAVASCRIPT_TAIL, "  [{}, {!r}, {!r}],"),
}


#: Largest number of times at which the file compares the run with exact values.
MOST_SAMPLES = 21


def reproduction(scenario: Scenario, engine: Engine, method: Method, timestep: float) -> str:
    """Return the text of a stand-alone program that repeats one run of an engine.

    The program is in Python or JavaScript, whichever the engine's scripts are in.

    Parameters
    ----------
    timestep : timestep of the run, s

    Raises
    ------
    Complaint
        If the method cannot simulate the scene, the engine writes no scripts, the scene's motion
        cannot be solved, or the timestep does not suit the scene.
    """
    if reason := engine.unsupported(scenario, method):
        raise Complaint(reason)
    with as_complaint(EngineError, before=f"{engine.name} {method.name}: ", exit_code=NOT_RUN):
        script = engine.script(scenario, method, timestep)
    if not script:
        raise Complaint(_without_script(scenario, engine))
    with as_complaint(ValueError, before="'--timestep': "):
        steps = single(timestep, scenario.times).sample_steps
    solution = solved(scenario, np.asarray(steps * timestep, dtype=float))
    frame = FRAMES[engine.script_language]
    head = frame.head.format(
        # The title goes into a docstring or a comment of one line.
        title=printable(scenario.title).replace("\\", "/").replace('"', "'"),
        engine=engine.name.partition("@")[0],
        engine_version=engine.version,
        method=method.name,
        timestep=timestep,
        version=version("spincheck"),
    )
    return head + script + _tail(frame, solution, steps)


def _without_script(scenario: Scenario, engine: Engine) -> str:
    """Return the message that an engine writes no scripts, with the names of those that do."""
    able = [one.name for one in engines().values() if _writes(one, scenario)]
    return f"'--engine' must be one of {', '.join(able)}, which write scripts, got '{engine.name}'"


def _writes(engine: Engine, scenario: Scenario) -> bool:
    """Whether an engine writes stand-alone scripts.

    An engine that raises `EngineError` does write scripts: it only refuses this scene.
    """
    try:
        return bool(engine.script(scenario, engine.methods[0], 1.0))
    except EngineError:
        return True


def _tail(frame: Frame, solution: Solution, steps: NDArray[np.int64]) -> str:
    """Return the code that follows the script: it compares the run with exact values.

    Parameters
    ----------
    frame : the templates of the program's language
    solution : the exact motion at the n times of the samples; `MOST_SAMPLES` at most are used
    steps : number of steps up to each of these times, (n,)
    """
    motion = solution.trajectory
    kept = np.unique(np.linspace(0, len(motion.t) - 1, MOST_SAMPLES).round().astype(int))
    columns = (steps, motion.q_world_body_wxyz, motion.omega_body)
    largest = float(np.linalg.norm(motion.omega_body, axis=1).max())
    rows = zip(*(column[kept].tolist() for column in columns), strict=True)
    return frame.tail.format(
        # For a body that does not turn, errors are absolute.
        largest=largest or 1.0,
        solved=printable(solution.method),
        omega=solution.uncertainty.omega,
        attitude=solution.uncertainty.attitude,
        rows="\n".join(frame.row.format(*row) for row in rows),
    )
