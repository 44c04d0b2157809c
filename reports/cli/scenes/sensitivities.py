"""The derivatives of the exact motion, which `reference` and `export` give if asked to."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....reference import IntegrationError, sensitivity
from ....scenarios import Scenario, Trajectory
from ..terminal import NOT_RUN, as_complaint, table

#: Meanings of the first and the last three rows of each array; and the same in `translation`.
ROWS = ["attitude, rad, body axes", "omega, rad/s, body axes"]
ROWS_OF_TRANSLATION = ["com, m, world axes", "velocity, m/s, world axes"]
HEADS = ("θx", "θy", "θz", "ωx", "ωy", "ωz")
HEADS_OF_TRANSLATION = ("x", "y", "z", "vx", "vy", "vz")
#: Meanings of the columns of arrays whose columns are neither one number nor a vector's components.
COLUMNS = {
    "state_transition": [
        f"{what} {x}" for what in ("attitude", "ω", "com", "velocity") for x in "xyz"
    ],
    "inertia": ["Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"],
    "moments": ["moment 1", "moment 2", "moment 3"],
}


def derivatives(scenario: Scenario, motion: Trajectory) -> dict[str, Any]:
    """Return the derivatives of a motion at its times (`Sensitivity`) as a dictionary, for JSON.

    The entries are the attributes of `Sensitivity`, and each of its parameters, by name. Arrays are
    lists; the entry `rows` tells what their rows mean. A `Complaint` is raised if the derivatives
    cannot be computed.
    """
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        found = sensitivity(scenario, motion)
    record = {"rows": ROWS} | vars(found) | dict(found.parameters)
    del record["parameters"]
    if found.translation:
        record["translation"] = {"rows": ROWS_OF_TRANSLATION} | _listed(found.translation)
    return _listed(record)


def _listed(record: Any) -> dict[str, Any]:
    """Return a copy of a dictionary in which arrays are replaced by lists, as JSON needs them."""
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in record.items()}


def print_derivatives(record: dict[str, Any]) -> None:
    """Print tables of the derivatives at each time, then the conditioning and the uncertainties.

    A row of a table has the derivatives with respect to one number, of the start or of the scene.
    Its columns are the quantities that are differentiated.

    Parameters
    ----------
    record : the dictionary that `derivatives` returns
    """
    for k, t in enumerate(record["t"]):
        print(f"Derivatives at t = {t:.10g} s by the start and by parameters, SI units:")
        table(list(_rows(record, HEADS, k, record["uncertainty"])))
        if record["translation"]:
            table(
                list(_rows(record["translation"], HEADS_OF_TRANSLATION, k, record["uncertainty"]))
            )
    print(
        f"Largest singular value of the state transition, ω in units of {record['rate']:.4g} rad/s:"
    )
    pairs = zip(record["t"], record["conditioning"], strict=True)
    table([{"t": t, "conditioning": value} for t, value in pairs])
    rows = record["uncertainty"].items()
    table([{"derivatives by": name, "uncertainty, relative": value} for name, value in rows])


def _rows(
    record: dict[str, Any], heads: tuple[str, ...], k: int, names: Any
) -> Iterator[dict[str, object]]:
    """Yield a table row for each number with respect to which derivatives are taken, at one time.

    Parameters
    ----------
    record : derivatives at all times, by name, as lists
    heads : headings of the columns: the quantities that are differentiated
    k : index of the time
    names : names of the derivatives in the record
    """
    for name in names:
        columns = np.atleast_2d(np.array(record[name][k]).T).tolist()
        ends = {1: [""], len("xyz"): [" x", " y", " z"]}.get(
            len(columns), [f" {j + 1}" for j in range(len(columns))]
        )
        labels = COLUMNS.get(name) or [f"{name}{end}" for end in ends]
        for label, column in zip(labels, columns, strict=False):
            yield {"by": label} | dict(zip(heads, column, strict=True))
