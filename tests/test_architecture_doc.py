"""What the pages for developers name exists, and the way of a scene is the one that a run takes."""

import ast
import inspect
import re
import sys
import threading
from pathlib import Path
from types import FrameType

import pytest
from case_loops import each_case
from command_line import spincheck
from spincheck.engines import Session
from spincheck.reference.compiled import compile_kernels

ROOT = Path(__file__).parents[1]
PAGES = (
    "project/architecture.md",
    "reference/glossary.md",
    "how-to/add-an-engine.md",
    "how-to/add-an-effect.md",
)
NAMED = [
    (page.name, name)
    for page in (ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / name for name in PAGES))
    for name in re.findall(r"`((?:\w+/)+[\w.]*(?::[\w.]+)?)`", page.read_text(encoding="utf-8"))
]
ARCHITECTURE = (ROOT / "docs/project/architecture.md").read_text(encoding="utf-8")
#: The rooms of the main line with their functions, and the rooms that answer them.
WAY = re.findall(r"^\| \d+ \|.*`([\w/.]+)(?::([\w.]+))?` \|$", ARCHITECTURE, re.MULTILINE)
TABLE_OF_ANSWERS = ARCHITECTURE.partition("These decide too")[2].partition("\n\nAll other")[0]
ANSWERING = set(re.findall(r"`([\w/]+\.py)`", TABLE_OF_ANSWERS))
TOPS = ("scenarios", "reference", "engines", "reports")
#: Folders all of whose files decide.
HARNESS = "reports/harness"
PARTS = ("timesteps", "comparison", "measuring", "judging", "scene_checks", "varied")
DECIDING = {"engines/checks", HARNESS, *(f"{HARNESS}/{part}" for part in PARTS)}
AT_MOST = 24
#: On the way from the thread to the run: the page has workers there.
IN_PROCESS = "reports/harness/executors/in_process.py"


class Trace:
    """The functions of the package that were called, by the files above them at the first call."""

    def __init__(self) -> None:
        self.calls: dict[tuple[str, str], set[str]] = {}
        self._files: dict[str, str] = {}

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        file = self._file(frame)
        called = (file, frame.f_code.co_qualname)
        if event == "call" and file and called not in self.calls:
            self.calls[called] = set()
            above = frame.f_back
            while above is not None:
                self.calls[called].add(self._file(above))
                above = above.f_back

    def _file(self, frame: FrameType) -> str:
        """Its path in the package; empty for tests, other packages and what is being imported."""
        path = frame.f_code.co_filename
        if path not in self._files:
            inside = path.startswith(tuple(f"{ROOT / top}/" for top in TOPS))
            self._files[path] = Path(path).relative_to(ROOT).as_posix() if inside else ""
        # Bodies of modules and classes run when they are imported.
        is_function = frame.f_code.co_flags & inspect.CO_OPTIMIZED
        is_named = frame.f_code.co_name != "<lambda>"
        return self._files[path] if is_function and is_named else ""


@pytest.fixture(scope="module")
def traces(tmp_path_factory: pytest.TempPathFactory) -> tuple[Trace, Trace]:
    """What `run` and `report` call for one scene and method, in this process."""
    # Else it would be compiled on the way.
    compile_kernels()
    folder = tmp_path_factory.mktemp("way")
    method = ("--engine", "mujoco", "--method", "RK4", "--quick")
    return traced("run", "fast-top", *method, folder=folder), traced("report", folder=folder)


def traced(*command: str, folder: Path) -> Trace:
    """What a command calls."""
    trace = Trace()
    threading.setprofile(trace)
    sys.setprofile(trace)
    try:
        done = spincheck(*command, cwd=folder)
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    assert done.returncode == 0
    return trace


def walked(traces: tuple[Trace, Trace]) -> list[tuple[Trace, tuple[str, str]]]:
    """The functions of the main line in the order of their calls; pages are made by `report`."""
    named = {(file, function or "root") for file, function in WAY}
    return [
        (trace, called)
        for trace, by_report in zip(traces, (False, True), strict=True)
        for called in trace.calls
        if called in named and called[0].startswith("reports/pages/") == by_report
    ]


def between(traces: tuple[Trace, Trace]) -> set[str]:
    """Files above a function of the main line that are not on it."""
    rooms = {file for file, _ in WAY} | {IN_PROCESS, ""}
    return set().union(*(trace.calls[called] for trace, called in walked(traces))) - rooms


def deciding(traces: tuple[Trace, Trace]) -> set[str]:
    """The files that were entered in folders all of whose files decide."""
    entered = {file for trace in traces for file, _ in trace.calls}
    return {file for file in entered if Path(file).parent.as_posix() in DECIDING}


def test_the_pages_name_files() -> None:
    assert len(NAMED) > 30


@each_case(("page", "name"), NAMED)
def test_every_file_and_function_they_name_exists(page: str, name: str) -> None:
    path, _, definition = name.partition(":")
    text = (ROOT / path).read_text(encoding="utf-8") if definition else ""
    assert (ROOT / path).exists()
    if path.endswith(".js"):
        assert f"function {definition}(" in text
    elif definition:
        body = ast.parse(text).body
        for part in definition.split("."):
            found = [n for n in body if getattr(n, "name", "") == part]
            assert found
            body = getattr(found[0], "body", [])


@pytest.mark.slow
def test_the_way_of_a_scene_is_walked_in_the_order_of_the_page(traces: tuple[Trace, Trace]) -> None:
    *rooms, (_, drawing) = [(file, function or "root") for file, function in WAY]
    assert [called for _, called in walked(traces)] == rooms
    assert len(WAY) <= AT_MOST
    assert drawing in (ROOT / WAY[-1][0]).read_text(encoding="utf-8")


@pytest.mark.slow
def test_nothing_stands_between_the_rooms_of_the_way(traces: tuple[Trace, Trace]) -> None:
    assert between(traces) == set()


@pytest.mark.slow
def test_every_room_that_decides_is_on_the_page(traces: tuple[Trace, Trace]) -> None:
    rooms = {file for file, _ in WAY}
    assert deciding(traces) - rooms == ANSWERING


def test_an_engine_has_to_give_what_its_page_lists() -> None:
    text = (ROOT / "docs/how-to/add-an-engine.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^\| `(\w+)(?:\(k\))?` \|", text, flags=re.MULTILINE))
    assert listed == Session.__abstractmethods__
