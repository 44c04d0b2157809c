"""Exact motions of spinning bodies, and what physics engines make of them.

This is the Python interface. The names in `__all__`, `spincheck.testing`, and `spincheck.engine`,
with which adapters of engines are written, are stable; everything else is private. Modules are
imported when a function is called, so that `import spincheck` takes no time.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from spincheck.reports.harness.gradients.compared import GradientRow
    from spincheck.reports.harness.recorded.judged import JudgedMotion
    from spincheck.reports.results.records import Row
    from spincheck.reports.results.verdicts import Verdict
    from spincheck.scenarios import Scenario

    from .exact_motion import ExactMotion
    from .stored import StoredResults

    #: A scene, given as its name in the library, the path of its file, the TOML tables of its file,
    #: or a `Scenario` that was loaded before.
    Scene = str | Path | Mapping[str, Any] | Scenario

__all__ = ["exact", "gradients", "judge", "judge_timesteps", "load", "results", "run"]


def load(scene: "Scene", name: str = "scene") -> "Scenario":
    """Return a scene as a `Scenario`, read and checked.

    A file of the current folder, such as `./fast-top.toml`, takes precedence over a scene of the
    library; then a warning is logged.

    Parameters
    ----------
    scene : its name in the library, the path of its file, or the TOML tables of its file as a dict,
        with lists or NumPy's arrays; a `Scenario` is returned as it is
    name : name that the scene gets if it is given as a dict

    Raises
    ------
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
    """
    from logging import getLogger

    from spincheck.scenarios import Scenario, find, from_tables, hiding_the_library
    from spincheck.scenarios import load as load_file

    if isinstance(scene, Scenario):
        return scene
    if isinstance(scene, Mapping):
        return from_tables(scene, name)
    (path,) = find([str(scene)])
    for sentence in hiding_the_library([str(scene)]):
        getLogger("spincheck").warning("%s", sentence)
    return load_file(path)


def exact(scene: "Scene") -> "ExactMotion":
    """Return the exact motion of a scene; its method `at` gives states at any times.

    The first call on a machine compiles the solver, after a logged warning.

    Raises
    ------
    spincheck.scenarios.ScenarioError
        As for `load`.
    """
    from .exact_motion import ExactMotion

    scenario = load(scene)
    _compile_first()
    return ExactMotion(scenario)


def gradients(
    scene: "Scene",
    *,
    engine: str,
    method: str,
    timestep: float | None = None,
    window: float | None = None,
) -> "list[GradientRow]":
    """Return verdicts on an engine's derivatives of its steps, compared with exact derivatives.

    The engine runs in a process of its own.

    Parameters
    ----------
    timestep : timestep of the window's steps, s; chosen by the motion's fastest rate if None
    window : length of the window over which gradients are compared, s; of 512 steps if None

    Returns
    -------
    One row for each derivative that the engine gives, with its verdict, and one for central
    differences of its steps. If the engine cannot simulate the scene, the last is the only row, and
    has the reason.

    Raises
    ------
    ValueError
        If there is no such engine or method, or if the timestep or the window is not a finite
        number above 0.
    spincheck.scenarios.ScenarioError
        As for `load`.
    """
    from .single_run import judged_gradients

    scenario = load(scene)
    _compile_first()
    return judged_gradients(scenario, engine, method, timestep, window)


def judge(
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
    timestep: float | None = None,
    precision: str | None = None,
    order: int = 1,
    noise_attitude: float | None = None,
    noise_omega: float | None = None,
) -> "JudgedMotion":
    """Return the errors of a recorded motion, and what explains them.

    Its `as_record()` returns what `spincheck judge --json` prints for a file.

    Parameters
    ----------
    t : (n,) s, increasing, from 0 on
    q_wxyz, q_xyzw : (n, 4) attitudes, body to world components; one of the two
    omega_body, omega_world : (n, 3) rad/s; at most one of the two; without either, ω is computed
        from the attitudes
    com, velocity : (n, 3) m and m/s, world axes, of the centre of mass, if recorded
    spins : (n, rotors) rad/s, relative to the body, of a scene with rotors, if recorded
    timestep : timestep with which the motion was computed, s; if None, the time between samples is
        assumed
    precision : "single" or "double", in which the motion was computed; if None, it is found from
        the numbers
    order : order of accuracy of the method with which the motion was computed
    noise_attitude, noise_omega : standard deviations of measured numbers, rad and rad/s; estimated
        if both are left out

    Raises
    ------
    ValueError
        If the arrays are not a motion, go beyond the time up to which the exact motion is known, or
        do not fit `timestep`, which must not be longer than the time between samples.
    spincheck.scenarios.ScenarioError
        As for `load`.
    """
    from .recorded import Made, judged

    made = Made(timestep, precision, order, noise_attitude, noise_omega)
    arrays = {"t": t, "q_wxyz": q_wxyz, "q_xyzw": q_xyzw, "omega_body": omega_body}
    arrays |= {"omega_world": omega_world, "com": com, "velocity": velocity}
    arrays["spins"] = spins
    scenario = load(scene)
    _compile_first()
    return judged(scenario, {name: a for name, a in arrays.items() if a is not None}, made)


def judge_timesteps(scene: "Scene", motions: "Sequence[JudgedMotion]", order: int = 1) -> "Verdict":
    """Return the verdict on a method, from its motions at a timestep halved again and again.

    Parameters
    ----------
    motions : what `judge` returned for each motion, with its timestep
    order : order of accuracy that the method has or claims

    Raises
    ------
    ValueError
        If timesteps are unknown or not halved, or the motions share no sample times.
    spincheck.scenarios.ScenarioError
        As for `load`.
    """
    from .recorded import verdict_on

    return verdict_on(load(scene), motions, order)


def run(scene: "Scene", *, engine: str, method: str, timestep: float) -> "Row":
    """Simulate a scene with one method and timestep, s, in a process of its own.

    Returns
    -------
    The run, with its `outcome`, `reason` and `motion`; `errors` is None unless the outcome is "ok".

    Raises
    ------
    ValueError
        If there is no such engine or method, or the timestep is not above 0 or is longer than the
        scene's window.
    spincheck.scenarios.ScenarioError
        As for `load`.
    """
    from .single_run import single_run

    scenario = load(scene)
    _compile_first()
    return single_run(scenario, engine, method, timestep)


def results(path: "str | Path") -> "StoredResults":
    """Return the runs and verdicts of a result file, as lists of records.

    Runs of ensembles are left out.

    Raises
    ------
    spincheck.reports.results.result_file.ResultFileError
        If the file is missing, is no result file of this format, or cannot be read.
    """
    from .stored import StoredResults

    return StoredResults.read(Path(path))


def _compile_first() -> None:
    """Compile the solver if it is not compiled yet, after a logged warning that this takes long."""
    from logging import getLogger

    from spincheck.reports.harness.executors.compiling import compile_first

    compile_first(getLogger("spincheck").warning)
