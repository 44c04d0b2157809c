"""The commands `reference` and `export --truth`, which print and write the exact motion."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ....reference import IntegrationError, Solution, drifts, facts, solve
from ....reference.euler_angles import euler_zyz_from_quaternion, rates_from_omega_body
from ....scenarios import (
    SIGNAL,
    FloatArray,
    Misfit,
    Scenario,
    angular_momentum_world,
    check_scales,
    energy,
    printable,
)
from ..choosing import compile_first
from ..terminal import NOT_RUN, Complaint, as_complaint, table
from .sensitivities import derivatives, print_derivatives

#: What each column of truth.csv holds, with its unit and its axes.
COLUMNS = {
    "t": "time, s",
    "quaternion_wxyz": "attitude, unit quaternion w x y z, takes body to world components",
    "omega_body": "angular velocity, rad/s, body axes",
    "com_world": "centre of mass, m, world axes",
    "velocity_world": "its velocity, m/s, world axes",
    "rotors_spin": "spins of the rotors, if there are any, relative to the body, rad/s",
    "L_world": "angular momentum about the pivot, or the centre of mass, kg m²/s, world axes",
    "energy": "kinetic and potential, J, the latter zero at the world's origin",
}
#: Endings of the names of a quantity's components, by their number.
LETTERS = {1: [""], 3: ["_x", "_y", "_z"], 4: ["_w", "_x", "_y", "_z"]}


def solved(scenario: Scenario, times: FloatArray) -> Solution:
    """Return the exact motion of a scene at times, s, (n,), increasing.

    The solver is compiled first if necessary. A `Complaint` is raised if the motion cannot be
    solved.
    """
    compile_first()
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        return solve(scenario, times)


def truth_files(scenario: Scenario, sensitivities: bool = False) -> dict[str, str]:
    """Return the texts of truth.csv and, if wanted, of sensitivities.json, by file name.

    The first has the motion at the scene's sample times, the second its derivatives. A `Complaint`
    is raised if the motion cannot be solved.
    """
    solution = solved(scenario, scenario.times)
    motion = solution.trajectory
    columns = {
        "t": motion.t,
        "quaternion_wxyz": motion.q_world_body_wxyz,
        "omega_body": motion.omega_body,
        "com_world": motion.com_world,
        "velocity_world": motion.velocity_world,
        **({"rotors_spin": motion.spins} if motion.spins.size else {}),
        "L_world": angular_momentum_world(scenario, motion),
        "energy": energy(scenario, motion),
    }
    texts = {"truth.csv": _csv(scenario, solution, columns)}
    if sensitivities:
        about = {"scenario": scenario.name, "source": "Exact motion by spincheck"}
        derived = about | derivatives(scenario, motion)
        texts["sensitivities.json"] = json.dumps(derived, indent=1, allow_nan=False) + "\n"
    return texts


def _csv(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    """Return a motion as CSV, after comments that state what its columns mean.

    Parameters
    ----------
    columns : the columns by name, (n,) or (n, components)
    """
    uncertainty = ", ".join(f"{name} {value:.1e}" for name, value in solution.uncertainty)
    about = [
        f"{printable(scenario.name)}: {printable(scenario.title)}",
        f"Exact motion by spincheck: {solution.method}.",
        f"Uncertainty, relative (attitude: rad): {uncertainty}.",
        *(f"{name}: {meaning}" for name, meaning in COLUMNS.items()),
    ]
    lines = [f"# {line}" for line in about]
    table = {name: values.reshape(len(values), -1) for name, values in columns.items()}
    heads = [f"{name}{end}" for name, v in table.items() for end in _ends(name, v.shape[1])]
    lines.append(",".join(heads))
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    lines += [",".join(repr(number) for part in row for number in part) for row in rows]
    return "\n".join([*lines, ""])


def _ends(name: str, count: int) -> list[str]:
    """Return the endings of the names of a quantity's components: numbers for rotors, else letters.

    Parameters
    ----------
    name : name of the quantity
    count : number of its components
    """
    return [f"_{k}" for k in range(1, count + 1)] if name == "rotors_spin" else LETTERS[count]


#: Number of times if a user names none: the start, the end, and three between.
QUARTERS = 5


def describe(
    scenario: Scenario, at: Sequence[float], sensitivities: bool = False
) -> dict[str, Any]:
    """Return the exact motion of a scene, in SI units, as a dictionary for JSON.

    Its entries are `scenario`, the scene's name; `method`, `uncertainty`, `conditioning`, `horizon`
    and `ending` of the `Solution`; `states`, one for each time, with quantities by name; `drifts`,
    by conserved quantity; `facts`, derived numbers; and, if wanted, `sensitivities`.

    Parameters
    ----------
    at : times of the states, s; if empty, `QUARTERS` times from the start to the end of the window
    sensitivities : whether the derivatives of the motion are included

    Raises
    ------
    Complaint
        If a time is negative, not finite or too late, or the motion cannot be solved.
    """
    for time in at:
        if not 0 <= time < float("inf"):
            raise Complaint(f"'--at' must be a time from 0 on, got {time:g}")
    wanted = np.array(sorted(set(at))) if at else np.linspace(0, scenario.window.duration, QUARTERS)
    with as_complaint(Misfit, before="'--at': "):
        check_scales(scenario, until=max(scenario.window.duration, float(wanted[-1])))
    solution = solved(scenario, wanted)
    motion = solution.trajectory
    angles = euler_zyz_from_quaternion(
        _upright(motion.q_world_body_wxyz, solution.uncertainty.attitude)
    )
    columns = {
        "t": motion.t,
        "quaternion_wxyz": motion.q_world_body_wxyz,
        "euler_zyz_deg": np.degrees(angles),
        # NaN (null in JSON) if β is 0 or π: α and γ have no rates of their own there.
        "euler_zyz_rates": rates_from_omega_body(angles, motion.omega_body),
        "omega_body": motion.omega_body,
        "omega_world": motion.to_world(motion.omega_body),
        "com_world": motion.com_world,
        "L_world": angular_momentum_world(scenario, motion),
        "energy": energy(scenario, motion),
    }
    if motion.spins.size:
        columns["rotors_spin"] = motion.spins
    for effect in scenario.acting:
        if effect.force is not None:
            columns[f"{effect.name}_force"] = effect.force_along(scenario, motion)
    derived = {"sensitivities": derivatives(scenario, motion)} if sensitivities else {}
    return {
        "scenario": scenario.name,
        "method": solution.method,
        "uncertainty": dict(solution.uncertainty),
        "conditioning": dict(solution.conditioning),
        "horizon": solution.horizon,
        "ending": solution.ending,
        "states": [
            {name: np.asarray(values)[k].tolist() for name, values in columns.items()}
            for k in range(len(motion.t))
        ],
        "drifts": drifts(scenario, motion),
        "facts": [asdict(fact) for fact in facts(scenario)],
    } | derived


def _upright(q_world_body_wxyz: FloatArray, uncertainty: float) -> FloatArray:
    """Return attitudes, (n, 4), in which a tilt near 0 or π is set to exactly 0 or π.

    It is near if it differs from 0 or π by the uncertainty at most. The Euler angles α and γ of
    such an attitude would otherwise consist of rounding errors.

    Parameters
    ----------
    q_world_body_wxyz : quaternions, scalar first, (n, 4)
    uncertainty : uncertainty of the attitude, rad
    """
    w_and_z = np.array([True, False, False, True])
    # The two norms are the sine of half the tilt, and the sine of half the angle from it to π.
    tilted = np.linalg.norm(q_world_body_wxyz[:, ~w_and_z], axis=1) > uncertainty / 2
    upright = np.linalg.norm(q_world_body_wxyz[:, w_and_z], axis=1) > uncertainty / 2
    kept = np.where(w_and_z, upright[:, None], tilted[:, None])
    return np.where(kept, q_world_body_wxyz, 0.0)


def print_truth(truth: dict[str, Any]) -> None:
    """Print, as lines and tables, a scene's exact motion: what `describe` returns."""
    print(f"{truth['scenario']}: {truth['method']}")
    for state in truth["states"]:
        print("\n".join(_state(state)))
    if truth["ending"]:
        print(f"The motion is known no longer: {truth['ending']}.\n")
    table(
        [
            {"": what} | {SIGNAL[name].label: size for name, size in truth[what].items()}
            for what in _ERRORS
        ]
    )
    table([{"conserved": name, "drift": drift} for name, drift in truth["drifts"].items()])
    table([{**fact, "value": _shown(fact["value"])} for fact in truth["facts"]])
    if "sensitivities" in truth:
        print_derivatives(truth["sensitivities"])


_ERRORS = ("uncertainty", "conditioning")


def _state(state: dict[str, Any]) -> Iterator[str]:
    """Yield a line with the time of a state, and a line for each of its other quantities.

    `state` has them by name: `t`, s, and numbers or lists of numbers, such as `omega_body`.
    Numbers have eight digits, so that four components fit into eighty columns.
    """
    yield f"\nt = {state['t']:.10g} s"
    for name, value in state.items():
        if name != "t":
            numbers = value if isinstance(value, list) else [value]
            words = "  ".join(f"{number:.8g}" for number in numbers)
            # Only rates of Euler angles are ever NaN.
            yield f" {name:16} {'undefined where β is 0° or 180°' if 'nan' in words else words}"


def _shown(value: Any) -> str:
    """Return a value as text, its numbers rounded for reading; `--json` has all digits."""
    if isinstance(value, list | tuple):
        return "  ".join(_shown(item) for item in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)
