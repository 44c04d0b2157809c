"""An engine in a package of its own is found, keeps the contract and appears in a report.

And one whose package raises on import costs only itself.
"""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from adapter_checks import CHECKS, Check
from library_scenes import library_scene
from spincheck.engines import discovery
from spincheck.reports.cli.terminal import NOT_RUN, refusal
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.pages.render import render
from spincheck.reports.results.store import open_store

pytestmark = pytest.mark.slow

STRANGER = Path(__file__).parent / "stranger"
#: What a package may raise, and not only that it lacks another.
RAISES = ["raise RuntimeError('built for numpy 1')", "1 / 0", "import sys; sys.exit(3)"]


def forget() -> None:
    for cached in (discovery.engines, discovery.missing, discovery._discover):
        cached.cache_clear()


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.syspath_prepend(str(STRANGER))
    forget()
    yield
    forget()


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_it_keeps_the_contract(installed: None, check: Check) -> None:
    toy = discovery.engines()["toy"]
    check(toy, toy.methods[0])


def test_it_is_short() -> None:
    assert len((STRANGER / "toy_engine.py").read_text().splitlines()) < 60


def test_it_appears_in_a_report(installed: None, tmp_path: Path) -> None:
    scene = library_scene("tennis-racket")
    choice = Choice((discovery.engines()["toy"],), (), (0.01,), timed=False)
    with open_store(tmp_path / "toy.sqlite", create=True) as store:
        run_study(plan([scene], choice, store), choice, store, InProcess(), lambda _: None)
        results = store.read()
    (row,) = [row for row in results.rows if row.timestep == 0.01]
    assert (row.key.engine, row.outcome) == ("toy", "ok")
    render(results, tmp_path / "report")
    assert "toy" in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Install a package `another_engine` of this source."""

    def installed(source: str) -> None:
        (tmp_path / "another_engine.py").write_text(source, encoding="utf-8")
        info = tmp_path / "another_engine-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Name: another-engine\nVersion: 1.0\n", encoding="utf-8")
        points = "[spincheck.engines]\nanother = another_engine\n"
        (info / "entry_points.txt").write_text(points, encoding="utf-8")
        monkeypatch.syspath_prepend(str(tmp_path))
        sys.modules.pop("another_engine", None)
        forget()

    yield installed
    forget()


@pytest.mark.parametrize("source", RAISES)
def test_a_package_that_raises_on_import_costs_only_its_own_engine(
    source: str, install: Callable[[str], None]
) -> None:
    install(source)
    assert "mujoco" in discovery.engines()
    (broken,) = [one for one in discovery.missing() if one.name == "another_engine"]
    assert "importing it failed" in broken.reason


def test_an_engine_named_as_another_ends_commands_with_one_message(
    install: Callable[[str], None],
) -> None:
    source = (STRANGER / "toy_engine.py").read_text(encoding="utf-8")
    install(source.replace('name = "toy"', 'name = "mujoco"'))
    with pytest.raises(
        discovery.NameTaken, match=r"named 'mujoco', .* and another_engine"
    ) as taken:
        discovery.engines()
    complaint = refusal(taken.value)
    assert complaint is not None
    assert complaint.exit_code == NOT_RUN
