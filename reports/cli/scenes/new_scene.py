"""What the command `new` does: a scene to edit, every key with its unit and meaning."""

from pathlib import Path

from ....scenarios import EFFECTS, is_scene_name, loads, printable
from ....scenarios.regular_files import write_new
from ..terminal import BAD_INPUT, Complaint

TEMPLATE = """\
spincheck = 1
title = "{name}"
source = "my own measurement"      # book, section or paper
tags = ["mine"]

[body]
mass = 0.5                         # kg
inertia = [8e-4, 8e-4, 4e-4]       # kg m²: principal moments about the com, or a 3×3 matrix
com = [0.0, 0.0, 0.05]             # m, from the body's origin, which is the pivot

[start]
euler_zyz_deg = [0.0, 30.0, 0.0]   # α, β (tilt), γ; or quaternion_wxyz, rotation_vector_deg
omega_body = [0.0, 0.0, 80.0]      # rad/s; or omega_world, or euler_zyz_rates

# An effect is simulated if its table is here, and only then.
{effects}
[window]
duration = 2.0                     # s
samples = 201                      # including t = 0
"""


#: Names of the tables that the scene begins with; the others are there as comments.
BEGINS_WITH = ("gravity", "pivot")


def _effects() -> str:
    """The tables of all effects."""
    texts = {e.table: f"{e.heading}\n{e.model.EXAMPLE}" for e in EFFECTS.values()}
    return "".join(
        line if name in BEGINS_WITH else f"# {line}"
        for name, text in texts.items()
        for line in text.splitlines(keepends=True)
    )


def new_scene(name: str) -> Path:
    """Write NAME.toml in the current folder.

    Raises
    ------
    Complaint
        If the name is not valid for a scene, or the file exists already.
    """
    name = name.removesuffix(".toml")
    if not is_scene_name(name):
        raise Complaint(
            "'NAME' must be letters, digits, '-', '_' and '.', the first a letter or digit, "
            f"got '{printable(name)}'",
            BAD_INPUT,
        )
    path, text = Path(f"{name}.toml"), TEMPLATE.format(name=name, effects=_effects())
    loads(text, name)
    try:
        write_new(path, text, replace=False)
    except FileExistsError:
        raise Complaint(f"{path}: exists already; choose another name", BAD_INPUT) from None
    return path
