"""Files that need no spincheck: a run to paste into an issue, and the exact motion."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.versions import VersionedEngine
from spincheck.reference import solve
from spincheck.reports.cli.app import app
from spincheck.reports.cli.engines.reproduce import reproduction
from spincheck.reports.cli.terminal import Complaint
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

TIMESTEP = 2e-3

# Together: a joint, a constraint, a free body, drag, torques in either axes, defaults.
RUNS = [
    ("fast-top", "mujoco", "Euler"),
    ("fast-top", "mujoco", "default"),
    ("fast-top", "pybullet", "default"),
    ("tiring-top", "pybullet", "multibody-p2p"),
    ("book-with-drag", "pybullet", "maximal"),
    ("stuck-thruster", "pybullet", "multibody"),
    ("gliding-top", "mujoco", "contact-RK4"),
]


@pytest.mark.needs_pybullet
@pytest.mark.parametrize(("scene", "name", "method"), RUNS)
def test_the_file_moves_as_the_adapter_to_the_last_bit(scene: str, name: str, method: str) -> None:
    scenario, engine = library_scene(scene), engines()[name]
    head = f"import numpy as np\nTIMESTEP = {TIMESTEP}\nproduct = conjugate = turned = None\n"
    run: dict[str, Any] = {}
    exec(head + engine.script(scenario, engine.method(method), TIMESTEP), run)
    with engine.open(scenario, engine.method(method), TIMESTEP) as session:
        for steps in (37, 64):
            session.advance(steps)
            run["step"](steps)
            assert coordinates(run) == coordinates(vars(session))
    if name == "pybullet":
        run["p"].disconnect(run["world"].client)


def coordinates(run: Mapping[str, Any]) -> object:
    """The motion of a script or session in the engine's own coordinates."""
    if "world" in run:
        return run["world"].motion()
    return [*run["data"].qpos, *run["data"].qvel]


@pytest.mark.needs_pybullet
@pytest.mark.parametrize(
    ("name", "method", "words"),
    [
        ("mujoco-file", "RK4", r"one of .*mujoco, .*pybullet.*, got 'mujoco-file'"),
        ("pybullet", "multibody-p2p", "multibody-p2p is for scenes with pivot"),
    ],
    ids=["mujoco-file", "pybullet"],
)
def test_what_has_no_script_or_cannot_simulate_the_scene_is_reported(
    name: str, method: str, words: str
) -> None:
    scenario, engine = library_scene("tennis-racket"), engines()[name]
    with pytest.raises(Complaint, match=words):
        reproduction(scenario, engine, engine.method(method), TIMESTEP)


def test_an_engine_at_a_version_has_the_script_of_its_adapter() -> None:
    """It has to run there: flags that a version lacks are none."""
    scenario, newest = library_scene("fast-top"), engines()["mujoco"]
    old = VersionedEngine("mujoco", "3.3.0", newest.methods, Path("nowhere"))
    text = reproduction(scenario, old, old.method("RK4"), TIMESTEP)
    assert "mujoco 3.3.0, RK4" in text
    assert "<flag" not in text
    assert "'spring'" in text
    assert "passive" in text


def test_the_exact_motion_as_csv_is_exact_to_the_last_bit(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["export", "hammer", str(tmp_path), "--truth"])
    assert result.exit_code == 0, result.output
    assert [path.name for path in tmp_path.iterdir()] == ["truth.csv"]
    scenario = library_scene("hammer")
    exact = solve(scenario, scenario.times).trajectory
    # The first line that is no comment names the columns.
    lines = (tmp_path / "truth.csv").read_text(encoding="utf-8").splitlines()
    heading, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    first = heading.index("omega_body_x")
    numbers = np.array(rows, dtype=float)
    assert np.array_equal(numbers[:, first : first + 3], exact.omega_body)
    assert np.array_equal(numbers[:, 0], exact.t)
