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

    A file in the current folder, such as `./fast-top.toml`, takes precedence over the library's
    scene of the same name. A warning is then logged.

    Parameters
    ----------
    scene : its name in the library, the path of its file, or the TOML tables of its file as a dict,
        with lists or NumPy arrays; a `Scenario` is returned as it is
    name : name of the scene if it is given as a dict

    Raises
    ------
    spincheck.scenarios.ScenarioError
        If there is no such scene, if a folder has several, or if the scene breaks a rule of the
        format.
    """
    from logging import getLogger

    from spincheck.scenarios import (
        Scenario,
        ScenarioError,
        find,
        from_tables,
        hiding_the_library,
        printable,
    )
    from spincheck.scenarios import load as load_file

    if isinstance(scene, Scenario):
        return scene
    if isinstance(scene, Mapping):
        return from_tables(scene, name)
    paths = find([str(scene)])
    if len(paths) > 1:
        raise ScenarioError(f"{printable(str(scene))}: takes one scene, this is {len(paths)}")
    for sentence in hiding_the_library([str(scene)]):
        getLogger("spincheck").warning("%s", sentence)
    return load_file(paths[0])


def exact(scene: "Scene") -> "ExactMotion":
    """Return the exact motion of a scene; its method `at` gives states at any times.

    The first call on a machine compiles the solver. A warning that this takes long is logged first.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`

    Raises
    ------
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
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

    The engine runs in a process of its own. Its derivatives of single steps are compared at several
    timesteps. Gradients through many steps are compared over a window of time.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`
    engine, method : names of an engine and of one of its methods
    timestep : timestep of the window's steps, s; if None, it follows from the fastest rate
    window : length of the window, s; 512 steps if None

    Returns
    -------
    One row for each derivative that the engine offers, with its verdict. A last row is for central
    differences of the engine's steps. If the engine cannot simulate the scene, this is the only
    row, and it has the reason.

    Raises
    ------
    ValueError
        If there is no such engine or method, if the engine cannot load the scene's body, or if the
        timestep or the window is not a finite number above 0.
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
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
    """Return the errors of a recorded motion, and the mistakes that explain them.

    The method `as_record()` of the result returns what `spincheck judge --json` prints for a file.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`
    t : times of the samples, s, (n,): increasing, none negative, 0 at the scene's start
    q_wxyz, q_xyzw : attitudes, (n, 4): unit quaternions, scalar first or last, that take body to
        world components; exactly one of the two arrays
    omega_body, omega_world : angular velocity, rad/s, (n, 3), in body or world axes; at most one of
        the two arrays; without either, ω is computed from the attitudes
    com, velocity : position, m, and velocity, m/s, of the centre of mass, (n, 3), world axes; None
        if not recorded
    spins : angular velocity of each rotor relative to the body, rad/s, (n, rotors); None if not
        recorded or if the scene has no rotors
    timestep : timestep with which the motion was computed, s; if None, the time between samples is
        assumed
    precision : "single" or "double", in which the motion was computed; if None, it is found from
        the numbers
    order : order of accuracy of the method with which the motion was computed
    noise_attitude, noise_omega : standard deviations of a measured motion's attitude, rad, and ω,
        rad/s; estimated if both are None

    Raises
    ------
    ValueError
        If the arrays do not describe a motion, if they go beyond the time up to which the exact
        motion is known, or if `timestep` is longer than the time between samples.
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
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
    """Return the verdict on a method, from its motions at timesteps halved again and again.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`
    motions : the result of `judge` for each motion, each judged with its `timestep`
    order : order of accuracy that the method has or claims

    Raises
    ------
    ValueError
        If the timesteps are unknown, or are not halves of one another, or if the motions share no
        sample times.
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
    """
    from .recorded import verdict_on

    return verdict_on(load(scene), motions, order)


def run(scene: "Scene", *, engine: str, method: str, timestep: float) -> "Row":
    """Simulate a scene with one method and timestep, in a process of its own.

    Parameters
    ----------
    scene : name in the library, path of a file, TOML tables as a dict, or a `Scenario`
    engine, method : names of an engine and of one of its methods
    timestep : s

    Returns
    -------
    The run, with its `outcome`, `reason` and `motion`; `errors` is None unless the outcome is "ok".

    Raises
    ------
    ValueError
        If there is no such engine or method, if the engine cannot load the scene's body, or if the
        timestep is not above 0 or is longer than the scene's window.
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
    """
    from .single_run import single_run

    scenario = load(scene)
    _compile_first()
    return single_run(scenario, engine, method, timestep)


def results(path: "str | Path") -> "StoredResults":
    """Return the runs and verdicts of a result file, as lists of records.

    Runs on members of ensembles, and those with some of an engine's defaults switched off, are left
    out.

    Raises
    ------
    spincheck.reports.results.result_file.ResultFileError
        If the file is missing, is not a result file of this format, or cannot be read.
    """
    from .stored import StoredResults

    return StoredResults.read(Path(path))


def _compile_first() -> None:
    """Compile the solver if it is not compiled yet; first log a warning that this takes long."""
    from logging import getLogger

    from spincheck.reports.harness.executors.compiling import compile_first

    compile_first(getLogger("spincheck").warning)
