"""Scripts in both languages, of all engines and planted ones; skipped if not installed."""

import ast
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from kinds_of_engines import OPTIONAL, why_missing
from spincheck.engines import Engine, Method, engines
from spincheck.engines.adapters.node.discovered import modules_folder
from spincheck.engines.child.process import end_idle
from spincheck.engines.session import Session
from spincheck.engines.user_cache import user_cache
from spincheck.reports.cli.engines import reproduce
from spincheck.reports.cli.engines.reproduce import FRAMES, reproduction
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import (
    DRAG,
    PIVOT,
    SKEW_GRAVITY,
    THROWN,
    TILTED,
    TORQUE_BODY,
    TORQUE_WORLD,
    scene,
)
from written_scripts import PRINTED, harness_errors, printed_errors, solved

pytestmark = pytest.mark.slow

TIMESTEP = 0.01
#: All effects that there are, held and free, of a body that is not aligned with its own frame; and
#: none.
SCENES_TO_WRITE = (
    scene("held", body=TILTED, effects=PIVOT + SKEW_GRAVITY + DRAG + TORQUE_BODY),
    scene("driven", body=TILTED, start=THROWN, effects=SKEW_GRAVITY + DRAG + TORQUE_WORLD),
    scene("free", body=TILTED),
)
#: JAX compiles each script for many seconds: one is run, in one precision.
COMPILED = "mjx"
#: All scripts in one process: importing an engine takes longer than a run.
RUN_PYTHON = "import runpy, sys\nfor file in sys.argv[1:]: print(file); runpy.run_path(file)"
#: The first argument of a script is the folder of npm packages.
RUN_JAVASCRIPT = "for (const f of process.argv.slice(3)) { console.log(f); await import(f); }"
RUN = {
    # -I: nothing but what is installed.
    "Python": (sys.executable, "-I", "-c", RUN_PYTHON),
    "JavaScript": (
        *["node", "--input-type=module", "-e"],
        RUN_JAVASCRIPT,
        "-",
        str(modules_folder()),
    ),
}


@pytest.fixture(scope="module", autouse=True)
def _nobody_left() -> Iterator[None]:
    yield
    end_idle()


@pytest.mark.parametrize("name", sorted({*OPTIONAL, "mujoco", "pybullet"} - {"mjx-float32"}))
def test_every_script_of_it_finds_the_errors_that_the_harness_finds(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if reason := why_missing(name):
        pytest.skip(reason)
    monkeypatch.setattr(reproduce, "solved", solved)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(user_cache() / "jax"))
    engine = engines()[name]
    written: dict[str, tuple[Scenario, Method]] = {}
    for scenario, method in product(SCENES_TO_WRITE, engine.methods):
        if name == COMPILED and (scenario, method) != (SCENES_TO_WRITE[0], engine.methods[0]):
            continue
        if engine.unsupported(scenario, method):
            continue
        suffix = FRAMES[engine.script_language].suffix
        file = tmp_path / f"{scenario.name}-{method.name}{suffix}"
        text = reproduction(scenario, engine, method, TIMESTEP)
        assert "spincheck" not in text.replace("by spincheck", "")
        file.write_text(text, encoding="utf-8")
        written[str(file)] = scenario, method
    assert written
    command = [*RUN[engine.script_language], *written]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for file, (scenario, method) in written.items():
        output = done.stdout.partition(f"{file}\n")[2].partition(f"{tmp_path}")[0]
        steps, errors = printed_errors(output, TIMESTEP)
        expected = harness_errors(scenario, engine, method, TIMESTEP, steps)
        assert errors == pytest.approx(expected, rel=PRINTED), f"{file}"


#: What ends a string, a comment or a line in Python or JavaScript.
HOSTILE = "*/ \"\"\" ''' ` ${x} {x} // # \\ \n\r\v\f\x85\u2028\u2029 boom \\"


#: A state that is no longer finite.
BLOWN_UP = {
    "Python": "step = abs\ndef state(): return np.ones(4), np.full(3, np.nan)\n",
    "JavaScript": "const step = Math.abs, state = () => [[1, 1, 1, 1], [NaN, NaN, NaN]];\n",
}


class Scripted(Engine):
    """An engine whose scripts blow up."""

    name, version, methods = "scripted", "1.0", engines()["mujoco"].methods

    def __init__(self, language: str) -> None:
        self.script_language = language

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        raise NotImplementedError

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        return BLOWN_UP[self.script_language]


@pytest.mark.parametrize("language", ["Python", "JavaScript"])
def test_no_title_gets_out_of_its_comment(language: str) -> None:
    plain, engine = SCENES_TO_WRITE[2], Scripted(language)
    document = plain.document.model_copy(update={"title": HOSTILE})
    texts = [
        reproduction(scenario, engine, engine.methods[0], TIMESTEP)
        for scenario in (plain, replace(plain, document=document))
    ]
    # Of Python's line ends JavaScript's are a part.
    (head, *rest), (hostile, *others) = (text.splitlines() for text in texts)
    assert rest == others
    assert "boom" in hostile
    if language == "Python":
        assert ast.get_docstring(ast.parse(texts[1])) != ast.get_docstring(ast.parse(texts[0]))
        assert len(ast.parse(texts[1]).body) == len(ast.parse(texts[0]).body)
    else:
        assert head.startswith("// ")
        assert hostile.startswith("// ")


@pytest.mark.parametrize("language", ["Python", "JavaScript"])
def test_a_script_that_blows_up_says_so_in_its_last_line(language: str, tmp_path: Path) -> None:
    if language == "JavaScript" and shutil.which("node") is None:
        pytest.skip("node is not installed")
    engine = Scripted(language)
    file = tmp_path / f"run{FRAMES[language].suffix}"
    text = reproduction(SCENES_TO_WRITE[2], engine, engine.methods[0], TIMESTEP)
    file.write_text(text, encoding="utf-8")
    command = [*RUN[language], str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1].lower().split()[:2] == ["largest", "nan"]
