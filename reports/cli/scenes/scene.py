"""What the commands `show` and `export` do."""

from pathlib import Path
from typing import Any

from ....engines.models.mjcf import mjcf
from ....engines.models.urdf import urdf
from ....scenarios import Scenario
from ....scenarios.regular_files import write_new

#: Default integrator of an exported MJCF, MuJoCo's most accurate, and the turn a step, rad, that it
#: resolves to a few digits.
EXPORTED_INTEGRATOR = "RK4"
EXPORTED_TURN = 0.05
#: s; MuJoCo's own default, for a scene that starts at rest.
EXPORTED_TIMESTEP = 0.002


def scene_as_json(scenario: Scenario) -> dict[str, Any]:
    """A scene as it was read: SI units; names tell body and world axes."""
    body, start = scenario.body, scenario.start
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
        "duration": scenario.window.duration,
        "samples": scenario.window.samples,
        "published": len(scenario.published),
        "expect": len(scenario.expect),
    }


def export_scene(scenario: Scenario, folder: Path) -> list[Path]:
    """Write scene.xml (MJCF) and scene.urdf; returns their paths.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    speed = float((scenario.start.omega_body**2).sum() ** 0.5)
    timestep = EXPORTED_TURN / speed if speed else EXPORTED_TIMESTEP
    texts = {
        "scene.xml": mjcf(scenario, timestep, EXPORTED_INTEGRATOR),
        "scene.urdf": urdf(scenario),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_new(folder / name, text)
    return [folder / name for name in texts]
