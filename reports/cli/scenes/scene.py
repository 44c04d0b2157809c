"""The commands `show`, `export` and `new`."""

from pathlib import Path
from typing import Any

from ....engines.models.mjcf import mjcf
from ....engines.models.urdf import urdf
from ....scenarios import EFFECTS, Scenario, is_scene_name, loads, printable
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.regular_files import write_new
from ..terminal import Complaint

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


#: Effects whose TOML tables are active in a new scene; those of all others are comments.
BEGINS_WITH = ("gravity", "pivot")


def _effects() -> str:
    """Return an example of each effect's TOML table; all but `BEGINS_WITH` are comments."""
    texts = {e.table: f"{e.heading}\n{e.model.EXAMPLE}" for e in EFFECTS.values()}
    return "".join(
        line if name in BEGINS_WITH else f"# {line}"
        for name, text in texts.items()
        for line in text.splitlines(keepends=True)
    )


def new_scene(name: str) -> Path:
    """Write a scene to edit, NAME.toml, into the current folder; return its path.

    `name` may end with ".toml". A `Complaint` is raised if it is no name of a scene, or the file
    exists already.
    """
    name = name.removesuffix(".toml")
    if not is_scene_name(name):
        raise Complaint(
            "'NAME' must be letters, digits, '-', '_' and '.', the first a letter or digit, "
            f"got '{printable(name)}'"
        )
    path, text = Path(f"{name}.toml"), TEMPLATE.format(name=name, effects=_effects())
    loads(text, name)
    try:
        write_new(path, text, replace=False)
    except FileExistsError:
        raise Complaint(f"{path}: exists already; choose another name") from None
    return path


#: Integrator of an exported MJCF, MuJoCo's most accurate one; and the angle turned in a step, rad,
#: from which the file's timestep follows: with it the motion is right to a few digits.
EXPORTED_INTEGRATOR = "RK4"
EXPORTED_TURN = 0.05
#: Timestep of a scene in which nothing moves, s: MuJoCo's own default.
EXPORTED_TIMESTEP = 0.002


def scene_as_json(scenario: Scenario) -> dict[str, Any]:
    """Return a scene as it was read, in SI units, as a JSON object."""
    body, start = scenario.body, scenario.start
    written = scenario.document.model_dump(exclude_none=True)
    tables = written | written["effects"]
    return {
        "scene": scenario.name,
        "source": scenario.document.source,
        "tags": list(scenario.document.tags),
        "effects": sorted(scenario.called_for),
        "mass": body.mass,
        "com": body.com.tolist(),
        "inertia_com": body.inertia_com.tolist(),
        "principal_moments": body.principal_moments.tolist(),
        "quaternion_wxyz": start.q_world_body_wxyz.tolist(),
        "omega_body": start.omega_body.tolist(),
        "position": start.position_world.tolist(),
        "velocity": start.velocity_world.tolist(),
        **{effect.table: tables[effect.table] for effect in scenario.acting},
        "duration": scenario.window.duration,
        "samples": scenario.window.samples,
        "published": len(scenario.document.published),
        "expect": len(scenario.expect),
    }


def model_files(scenario: Scenario) -> dict[str, str]:
    """Return the texts of a scene's model files, scene.xml (MJCF) and scene.urdf, by file name."""
    rate = fastest_rate(scenario, scenario.start.omega_body)
    timestep = EXPORTED_TURN / rate if rate else EXPORTED_TIMESTEP
    return {
        "scene.xml": mjcf(scenario, timestep, EXPORTED_INTEGRATOR),
        "scene.urdf": urdf(scenario),
    }
