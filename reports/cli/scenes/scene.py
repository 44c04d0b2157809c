"""The commands `show`, `export` and `new`."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ....engines.checks.read_back import start_state
from ....engines.models.mjcf import mjcf
from ....engines.models.urdf import urdf
from ....scenarios import EFFECTS, Scenario, is_scene_name, loads, printable
from ....scenarios.effects.effect import Effect
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.load import LONGEST_NAME
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
    """Return an example of each effect's TOML table, as text for a new scene's file.

    The tables of effects other than those in `BEGINS_WITH` are comments.
    """
    texts = {e.table: f"{e.heading}\n{e.model.EXAMPLE}" for e in EFFECTS.values()}
    return "".join(
        line if name in BEGINS_WITH else f"# {line}"
        for name, text in texts.items()
        for line in text.splitlines(keepends=True)
    )


def new_scene(name: str) -> Path:
    """Write a scene to edit, NAME.toml, into the current folder; return its path.

    `name` may end with ".toml". A `Complaint` is raised if a scene cannot have that name, or if the
    file exists already.
    """
    name = name.removesuffix(".toml")
    if not is_scene_name(name):
        raise Complaint(
            "'NAME' must be letters, digits, '-', '_' and '.', the first a letter or digit, "
            f"{LONGEST_NAME} bytes at most, got '{printable(name)}'"
        )
    path, text = Path(f"{name}.toml"), TEMPLATE.format(name=name, effects=_effects())
    loads(text, name)
    try:
        write_new(path, text, replace=False)
    except FileExistsError:
        raise Complaint(f"{path}: exists already; choose another name") from None
    return path


#: Integrator of an exported MJCF file, MuJoCo's most accurate one; and the angle that the fastest
#: rate turns in one of its timesteps, rad: small enough for a motion that is right to a few digits.
EXPORTED_INTEGRATOR = "RK4"
EXPORTED_TURN = 0.05
#: Timestep of a scene in which nothing moves, s: MuJoCo's own default.
EXPORTED_TIMESTEP = 0.002


#: What the values of `scene_as_json` are, by key: unit, point of reference and axes.
MEANINGS = {
    "mass": "kg",
    "com": "m, centre of mass from the body's origin, body axes",
    "inertia_com": "kg m², about the centre of mass, body axes",
    "principal_moments": "kg m², about the centre of mass",
    "quaternion_wxyz": "attitude at t = 0, body to world, scalar first",
    "omega_body": "rad/s, at t = 0, body axes",
    "position": "m, of the centre of mass at t = 0, world axes",
    "velocity": "m/s, of the centre of mass at t = 0, world axes",
    "duration": "s",
    "samples": "evenly spaced times, t = 0 and the end included",
    "published": "times with published values",
    "expect": "expectations of engines",
}
#: Quantities that count rotors as fixed parts of the body.
OF_THE_WHOLE = ("mass", "com", "inertia_com", "principal_moments")
#: Digits of numbers that are printed for people; in JSON they have all digits.
DIGITS = 7


def scene_as_json(scenario: Scenario) -> dict[str, Any]:
    """Return a scene as it was read, in SI units, as a JSON object.

    It has names, body, start and window as single entries, such as `mass` and `omega_body`; the
    TOML table of each effect by its name; and how many published values and expectations there are.
    """
    body, start = scenario.body, start_state(scenario)
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
        "position": start.com_world.tolist(),
        "velocity": start.velocity_world.tolist(),
        **{effect.table: _table(scenario, effect) for effect in scenario.acting},
        "duration": scenario.window.duration,
        "samples": scenario.window.samples,
        "published": len(scenario.document.published),
        "expect": len(scenario.expect),
    }


def _table(scenario: Scenario, effect: Effect) -> Any:
    """Return an effect's TOML table in a scene's file, or its list of tables."""
    written = scenario.document.model_dump(exclude_none=True)
    return (written | written["effects"])[effect.table]


def scene_rows(scenario: Scenario) -> Iterator[dict[str, str]]:
    """Yield each value of `scene_as_json` with its unit, as a row of a table for users.

    The headings of the columns are the keys: none for the value's name, "value" and "unit".
    """
    described = scene_as_json(scenario)
    for effect in scenario.acting:
        described[effect.table] = effect
    for name, value in described.items():
        if isinstance(value, Effect):
            yield from _effect_rows(value, _table(scenario, value))
            continue
        has_parts = scenario.carrier.mass != scenario.body.mass
        counted = "; with parts that turn in it" if name in OF_THE_WHOLE and has_parts else ""
        yield _row(name, value, MEANINGS.get(name, "") + counted)


def _effect_rows(effect: Effect, table: Any) -> Iterator[dict[str, str]]:
    """Yield a row for each key of an effect's TOML table, or of each table if it has several."""
    tables = {f"{effect.table} {k + 1}": one for k, one in enumerate(table)}
    tables = tables if isinstance(table, list | tuple) else {effect.table: table}
    for name, one in tables.items():
        if not one:
            yield _row(name, "", effect.model.__doc__ or "")
        for key, value in one.items():
            yield _row(f"{name}: {key}", value, effect.model.model_fields[key].description or "")


def _row(name: str, value: Any, meaning: str) -> dict[str, str]:
    """Return a row of a scene's table, by the headings of the columns.

    The value is written as JSON unless it is a text, and its numbers have `DIGITS` digits.
    `meaning` is the value's unit or meaning.
    """
    shown = value if isinstance(value, str) else json.dumps(_rounded(value), ensure_ascii=False)
    return {"": name, "value": shown, "unit": meaning}


def _rounded(value: Any) -> Any:
    """Return a value with each of its floats rounded to `DIGITS` digits."""
    if isinstance(value, list | tuple):
        return [_rounded(one) for one in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def model_files(scenario: Scenario) -> dict[str, str]:
    """Return the texts of a scene's model files, scene.xml (MJCF) and scene.urdf, by file name."""
    rate = fastest_rate(scenario, scenario.start.omega_body)
    timestep = EXPORTED_TURN / rate if rate else EXPORTED_TIMESTEP
    texts = {
        "scene.xml": mjcf(scenario, timestep, EXPORTED_INTEGRATOR),
        "scene.urdf": urdf(scenario),
    }
    return {name: f"<!-- Written by spincheck. -->\n{text}" for name, text in texts.items()}
