"""What the commands `reference` and `export --truth` do: the exact motion, printed and as files."""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from textwrap import wrap
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

#: What each column is, with its unit and its axes.
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
#: Letters of a column's components.
LETTERS = {1: [""], 3: ["_x", "_y", "_z"], 4: ["_w", "_x", "_y", "_z"]}
#: Characters of a line of the header's numbers.
WIDTH = 96


def solved(scenario: Scenario, times: FloatArray) -> Solution:
    """The exact motion at times, s; what solves it is compiled first."""
    compile_first()
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        return solve(scenario, times)


def truth_files(scenario: Scenario, sensitivities: bool = False) -> dict[str, str]:
    """The texts of truth.csv, truth.json and truth.h, and of sensitivities.json if wanted."""
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
    formats = {"truth.csv": _csv, "truth.json": _json, "truth.h": _c_header}
    texts = {name: text_of(scenario, solution, columns) for name, text_of in formats.items()}
    if sensitivities:
        derived = {"scenario": scenario.name} | derivatives(scenario, motion)
        texts["sensitivities.json"] = json.dumps(derived, indent=1, allow_nan=False) + "\n"
    return texts


def _header_lines(scenario: Scenario, solution: Solution) -> Iterator[str]:
    yield f"{printable(scenario.name)}: {printable(scenario.title)}"
    yield f"Exact motion by spincheck: {solution.method}."
    uncertainty = ", ".join(f"{name} {value:.1e}" for name, value in solution.uncertainty)
    yield f"Uncertainty, relative (attitude: rad): {uncertainty}."
    for name, meaning in COLUMNS.items():
        yield f"{name}: {meaning}"


def _csv(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    lines = [f"# {line}" for line in _header_lines(scenario, solution)]
    table = {name: values.reshape(len(values), -1) for name, values in columns.items()}
    heads = [f"{name}{end}" for name, v in table.items() for end in _ends(name, v.shape[1])]
    lines.append(",".join(heads))
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    lines += [",".join(repr(number) for part in row for number in part) for row in rows]
    return "\n".join([*lines, ""])


def _ends(name: str, count: int) -> list[str]:
    """What the components of a column have behind its name: rotors are numbered."""
    return [f"_{k}" for k in range(1, count + 1)] if name == "rotors_spin" else LETTERS[count]


def _json(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    content = {
        "scenario": scenario.name,
        "title": scenario.title,
        "method": solution.method,
        "uncertainty": dict(solution.uncertainty),
        "units_and_frames": COLUMNS,
        "columns": {name: values.tolist() for name, values in columns.items()},
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _c_header(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    name = re.sub(r"[^A-Za-z0-9]", "_", f"spincheck_{scenario.name}")
    comment = "\n".join(
        f" * {line.replace('*/', '* /')}" for line in _header_lines(scenario, solution)
    )
    parts = [
        f"/*\n{comment}\n */",
        f"#ifndef {name.upper()}_H\n#define {name.upper()}_H",
        f"enum {{ {name}_samples = {len(columns['t'])} }};",
        *(
            f"static const double {name}_{what}_uncertainty = {value!r};"
            for what, value in solution.uncertainty
        ),
        *(_c_array(f"{name}_{what}", values) for what, values in columns.items()),
        "#endif",
    ]
    return "\n\n".join([*parts, ""])


def _c_array(name: str, values: FloatArray) -> str:
    rows = values.tolist()
    size = f"[{len(rows)}]" + (f"[{len(rows[0])}]" if values.ndim > 1 else "")
    numbers = ", ".join(_c_row(row) if values.ndim > 1 else repr(row) for row in rows)
    return (
        f"static const double {name}{size} = {{\n"
        + "\n".join(wrap(numbers, WIDTH, break_on_hyphens=False))
        + "\n};"
    )


def _c_row(row: list[float]) -> str:
    return "{" + ", ".join(repr(number) for number in row) + "}"


#: Where a user names no times: the start, the end, and three between.
QUARTERS = 5


def describe(
    scenario: Scenario, at: Sequence[float], sensitivities: bool = False
) -> dict[str, Any]:
    """States, uncertainty, conserved quantities and facts of a scene, SI units.

    And its derivatives, if they are wanted.
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
        # NaN (null in JSON) where β is 0 or π: α and γ have no rates of their own there.
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
    """Attitudes, (n, 4), those whose tilt is 0 or π to within an uncertainty, rad, made exactly so.

    Azimuth and turn of the others would be those of rounding.
    """
    w_and_z = np.array([True, False, False, True])
    # Sines of half the tilt, and of half of what it lacks to π.
    tilted = np.linalg.norm(q_world_body_wxyz[:, ~w_and_z], axis=1) > uncertainty / 2
    upright = np.linalg.norm(q_world_body_wxyz[:, w_and_z], axis=1) > uncertainty / 2
    kept = np.where(w_and_z, upright[:, None], tilted[:, None])
    return np.where(kept, q_world_body_wxyz, 0.0)


def print_truth(truth: dict[str, Any]) -> None:
    """Print a description as tables."""
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
    """A line a quantity below the time; four components with exponents fit eighty columns."""
    yield f"\nt = {state['t']:.10g} s"
    for name, value in state.items():
        if name != "t":
            numbers = value if isinstance(value, list) else [value]
            words = "  ".join(f"{number:.8g}" for number in numbers)
            # Rates of Euler angles alone are ever NaN.
            yield f" {name:16} {'undefined where β is 0° or 180°' if 'nan' in words else words}"


def _shown(value: Any) -> str:
    """Numbers rounded for reading; `--json` has all digits."""
    if isinstance(value, list | tuple):
        return "  ".join(_shown(item) for item in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)
