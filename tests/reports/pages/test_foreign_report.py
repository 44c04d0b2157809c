"""A report of a result file from elsewhere: what its engines declared is in the file."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from made_up import METHODS, put, results
from page import read_page
from spincheck.engines import Engine, Method
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.results.store import open_store
from spincheck.scenarios import EFFECTS, Scenario

pytestmark = pytest.mark.slow

#: Makes a report where no engine is installed.
RENDER = """
import sys
from pathlib import Path
sys.modules["mujoco"] = sys.modules["pybullet"] = None
from spincheck.engines import engines
from spincheck.reports.pages.render import render
from spincheck.reports.cli.run.running import read
assert not {"mujoco", "pybullet"} & set(engines())
render(read(Path(sys.argv[1])), Path(sys.argv[2]))
"""
FANCY, PLAIN = "fancy<i>", "plain"


class Elsewhere(Engine):
    """An engine that is not installed here."""

    name = "elsewhere"
    version = "0.9"
    methods = (
        Method(PLAIN, 3, 2, "as plain as can be", frozenset(EFFECTS), as_shipped=True),
        Method(FANCY, 2, 2, "fancy", frozenset({"pivot"}), frozenset({"pivot"}), 0.5),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> None:
        raise NotImplementedError


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "theirs.sqlite"
    with open_store(path, create=True) as store:
        put(store, results())
        store.put_methods([Elsewhere()])
    return path


def test_what_was_declared_comes_back_from_the_file_until_another_is(path: Path) -> None:
    now = type("Now", (Elsewhere,), {"methods": (replace(Elsewhere.methods[1], order=4),)})
    with open_store(path, create=True) as store:
        declared = store.read().methods
        assert list(declared.items()) == [(("elsewhere", m.name), m) for m in Elsewhere.methods]
        store.put_methods([now()])
        assert store.read().methods == {("elsewhere", FANCY): now.methods[0]}


def test_methods_are_reported_in_the_order_of_their_engine_and_others_left_open(path: Path) -> None:
    with open_store(path) as store:
        gathered = report_data(store.read())
    (mujoco, *_) = (runs for runs in gathered.scenes[0].methods if runs.engine == "mujoco")
    assert mujoco.declared is None
    assert [method for engine, method in gathered.pairs if engine == "elsewhere"] == [PLAIN, FANCY]
    assert [m.method for m in METHODS if m.engine == "elsewhere"] == [FANCY, PLAIN]


def test_a_report_needs_no_engine(path: Path, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    done = subprocess.run(
        [sys.executable, "-c", RENDER, path, folder], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    rows = [row for table in read_page(folder / "index.html").tables() for row in table]
    (plain,) = (row for row in rows if row[0] == "elsewhere" and row[2].startswith(PLAIN))
    assert "as plain as can be" in plain[2]
    assert plain[3] == "ω 3, attitude 2"
