"""Files that need no spincheck: a run to paste into an issue, and the exact motion."""

import json
import shutil
import subprocess
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


@pytest.fixture(scope="module")
def exact_motion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("truth")
    result = CliRunner().invoke(app, ["export", "hammer", str(folder), "--truth"])
    assert result.exit_code == 0, result.output
    return folder


def test_the_exact_motion_as_csv_and_as_json_are_the_same_to_the_last_bit(
    exact_motion: Path,
) -> None:
    scenario = library_scene("hammer")
    exact = solve(scenario, scenario.times).trajectory
    columns = json.loads((exact_motion / "truth.json").read_text(encoding="utf-8"))["columns"]
    assert np.array_equal(columns["omega_body"], exact.omega_body)
    # The first line that is no comment names the columns.
    lines = (exact_motion / "truth.csv").read_text(encoding="utf-8").splitlines()
    heading, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    first = heading.index("omega_body_x")
    numbers = np.array(rows, dtype=float)
    assert np.array_equal(numbers[:, first : first + 3], exact.omega_body)
    assert np.array_equal(numbers[:, 0], exact.t)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_exact_motion_as_a_c_header_compiles_and_reads_the_same(
    exact_motion: Path, tmp_path: Path
) -> None:
    program = tmp_path / "program.c"
    program.write_text(
        '#include <stdio.h>\n#include "truth.h"\nint main(void) {\n'
        '  printf("%.17g", spincheck_hammer_omega_body[spincheck_hammer_samples - 1][2]);\n'
        "  return spincheck_hammer_omega_uncertainty < 0;\n}\n",
        encoding="utf-8",
    )
    out = tmp_path / "program"
    subprocess.run(["cc", f"-I{exact_motion}", str(program), "-o", str(out)], check=True)
    printed = subprocess.run([str(out)], capture_output=True, text=True, check=True).stdout
    columns = json.loads((exact_motion / "truth.json").read_text(encoding="utf-8"))["columns"]
    assert float(printed) == columns["omega_body"][-1][2]
