"""The exact motion as files for test suites in any language: CSV, JSON, a C header."""

import json
import re
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from textwrap import wrap

from ....reference import IntegrationError, Solution, solve
from ....scenarios import FloatArray, Scenario, angular_momentum_world, energy, printable
from ....scenarios.regular_files import write_new
from ..executing import compile_first
from ..terminal import NOT_RUN, as_complaint

#: What each column is, with its unit and its axes.
COLUMNS = {
    "t": "time, s",
    "quaternion_wxyz": "attitude, unit quaternion w x y z, takes body to world components",
    "omega_body": "angular velocity, rad/s, body axes",
    "com_world": "centre of mass, m, world axes",
    "velocity_world": "its velocity, m/s, world axes",
    "L_world": "angular momentum about the pivot, or the centre of mass, kg m²/s, world axes",
    "energy": "kinetic and potential, J, the latter zero at the world's origin",
}
#: Letters of a column's components.
LETTERS = {1: [""], 3: ["_x", "_y", "_z"], 4: ["_w", "_x", "_y", "_z"]}
#: Characters of a line of the header's numbers.
WIDTH = 96


def write_truth(scenario: Scenario, folder: Path) -> list[Path]:
    """Write truth.csv, truth.json and truth.h; returns their paths.

    Raises
    ------
    Complaint
        If the motion cannot be solved.
    OSError
        If the folder cannot be written.
    """
    compile_first()
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        solution = solve(scenario, scenario.times)
    motion = solution.trajectory
    columns = {
        "t": motion.t,
        "quaternion_wxyz": motion.q_world_body_wxyz,
        "omega_body": motion.omega_body,
        "com_world": motion.com_world,
        "velocity_world": motion.velocity_world,
        "L_world": angular_momentum_world(scenario, motion),
        "energy": energy(scenario, motion),
    }
    texts = {
        "truth.csv": _csv(scenario, solution, columns),
        "truth.json": _json(scenario, solution, columns),
        "truth.h": _c_header(scenario, solution, columns),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_new(folder / name, text)
    return [folder / name for name in texts]


def _header_lines(scenario: Scenario, solution: Solution) -> Iterator[str]:
    yield f"{printable(scenario.name)}: {printable(scenario.title)}"
    yield f"Exact motion by spincheck: {solution.method}."
    uncertainty = ", ".join(
        f"{name} {value:.1e}" for name, value in asdict(solution.uncertainty).items()
    )
    yield f"Uncertainty, relative (attitude: rad): {uncertainty}."
    for name, meaning in COLUMNS.items():
        yield f"{name}: {meaning}"


def _csv(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    lines = [f"# {line}" for line in _header_lines(scenario, solution)]
    table = {name: values.reshape(len(values), -1) for name, values in columns.items()}
    heads = [f"{name}{end}" for name, v in table.items() for end in LETTERS[v.shape[1]]]
    lines.append(",".join(heads))
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    lines += [",".join(repr(number) for part in row for number in part) for row in rows]
    return "\n".join([*lines, ""])


def _json(scenario: Scenario, solution: Solution, columns: dict[str, FloatArray]) -> str:
    content = {
        "scenario": scenario.name,
        "title": scenario.title,
        "method": solution.method,
        "uncertainty": asdict(solution.uncertainty),
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
            for what, value in asdict(solution.uncertainty).items()
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
