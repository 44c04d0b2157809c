"""What the command `reproduce` writes: one run as a file that needs no spincheck."""

from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from ....engines import Engine, EngineError, Method, engines
from ....reference import IntegrationError, Solution, solve
from ....scenarios import Scenario, printable
from ...harness.ladder import single
from ..executing import compile_first
from ..terminal import BAD_INPUT, NOT_RUN, Complaint, as_complaint
from .script_frames import FRAMES, Frame

#: Times at which the file compares.
MOST_SAMPLES = 21


def reproduction(scenario: Scenario, engine: Engine, method: Method, timestep: float) -> str:
    """The text of the file, in the language of the engine's script.

    Raises
    ------
    Complaint
        If the engine has no script, cannot simulate the scene with this method, or the exact motion
        is not known so far.
    """
    if reason := engine.unsupported(scenario, method):
        raise Complaint(reason, BAD_INPUT)
    with as_complaint(EngineError, before=f"{engine.name} {method.name}: ", exit_code=NOT_RUN):
        script = engine.script(scenario, method, timestep)
    if not script:
        raise Complaint(_without_script(scenario, engine, method), BAD_INPUT)
    with as_complaint(ValueError, before="'--timestep': "):
        steps = single(timestep, scenario.times).sample_steps
    compile_first()
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        solution = solve(scenario, np.asarray(steps * timestep, dtype=float))
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


def _without_script(scenario: Scenario, engine: Engine, method: Method) -> str:
    """That a method or an engine has none, and which have."""
    offered = engine.methods_for(scenario)
    if of_it := [one.name for one in offered if _writes(engine, scenario, one)]:
        words = f"{', '.join(of_it)}, which {engine.name} writes scripts of"
        return f"'--method' must be one of {words}, got '{method.name}'"
    able = [one.name for one in engines().values() if _writes(one, scenario, one.methods[0])]
    return f"'--engine' must be one of {', '.join(able)}, which write scripts, got '{engine.name}'"


def _writes(engine: Engine, scenario: Scenario, method: Method) -> bool:
    """Whether it has scripts, if not of this scene."""
    try:
        return bool(engine.script(scenario, method, 1.0))
    except EngineError:
        return True


def _tail(frame: Frame, solution: Solution, steps: NDArray[np.int64]) -> str:
    motion = solution.trajectory
    kept = np.unique(np.linspace(0, len(motion.t) - 1, MOST_SAMPLES).round().astype(int))
    columns = (steps, motion.q_world_body_wxyz, motion.omega_body)
    largest = float(np.linalg.norm(motion.omega_body, axis=1).max())
    rows = zip(*(column[kept].tolist() for column in columns), strict=True)
    return frame.tail.format(
        # Of a body that does not turn errors are absolute.
        largest=largest or 1.0,
        solved=printable(solution.method),
        omega=solution.uncertainty.omega,
        attitude=solution.uncertainty.attitude,
        rows="\n".join(frame.row.format(*row) for row in rows),
    )
