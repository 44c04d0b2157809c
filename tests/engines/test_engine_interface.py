"""The interface of adapters keeps what docs/how-to/add-an-engine.md promises.

Verified: three engines that were written for version 1, in packages of their own, run unchanged;
whatever that version had is there, and asks for no more; an adapter that is too old or too new, or
that raises on import, costs only itself; a deprecated member warns and names its replacement; the
adapters here read no more of a scene than the page lists.
Not verified: that numbers mean the same as in version 1, but for what the three engines use.
"""

import inspect
import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterator
from hashlib import sha256
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
import spincheck.engine
from adapter_checks import CHECKS, Check
from case_loops import each_case
from command_line import ended
from library_scenes import library_scene
from spincheck.engine import Engine, Session
from spincheck.engines import discovery
from spincheck.engines.discovery import HOW
from spincheck.engines.interface import misfit
from spincheck.reports.cli.choosing import choose
from spincheck.reports.cli.terminal import NOT_RUN, refusal
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.pages.render import render
from spincheck.reports.results.store import open_store
from typing_extensions import deprecated

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how-to/add-an-engine.md").read_text(encoding="utf-8")
FROZEN = Path(__file__).parent / "interface_1"
PACKAGES = {"toy": FROZEN / "free_body", "heavy-top": FROZEN / "pivot"}
TOY = FROZEN / "free_body/toy_engine.py"
#: What the files of version 1 must stay: whoever has to edit one breaks the promise.
DIGESTS = {
    "free_body/toy_engine.py": "6f5672508f008e01f548073f558e0d050d786e7fa139e9ba69356f58f18ed3f3",
    "pivot/heavy_top_engine.py": "ca328f39ecaf5ec461776ac16d1aa108aee9d382e14ebbe49056f21f1835977b",
    "toy.mjs": "c5aed1b26d89b30b13aea1d74f45f449b84dba92f97c771b746f50fa2e1ad443",
    "members.json": "ebfa1eb0e6e6ad04c64aad83b99b4ed36f20a1b948b539700128a92239c85b2c",
}
#: What version 1 had: parameters by the names of what is called, and what adapters have to write.
MEMBERS = json.loads((FROZEN / "members.json").read_text(encoding="utf-8"))


def forget() -> None:
    for cached in (discovery.engines, discovery.missing, discovery._discover):
        cached.cache_clear()


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for package in PACKAGES.values():
        monkeypatch.syspath_prepend(str(package))
    forget()
    yield
    forget()


def test_frozen_files_are_not_edited() -> None:
    assert {name: sha256((FROZEN / name).read_bytes()).hexdigest() for name in DIGESTS} == DIGESTS


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", PACKAGES)
def test_engines_of_version_1_keep_the_contract(installed: None, name: str, check: Check) -> None:
    engine = discovery.engines()[name]
    check(engine, engine.methods[0])


@pytest.mark.parametrize(
    ("name", "scene"), [("toy", "football-spiral"), ("heavy-top", "tiring-top")]
)
def test_they_converge_and_appear_in_a_report(
    installed: None, tmp_path: Path, name: str, scene: str
) -> None:
    choice = Choice((discovery.engines()[name],), (), (), timed=False, max_steps=1 << 9)
    with open_store(tmp_path / "of_one.sqlite", create=True) as store:
        planned = plan([library_scene(scene)], choice, store)
        run_study(planned, choice, store, InProcess(), lambda _: None)
        results = store.read()
    assert [verdict.verdict for verdict in results.verdicts] == ["converges"]
    render(results, tmp_path / "report")
    assert name in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")


def breaches(members: dict[str, Any]) -> Iterator[str]:
    """What an adapter for these members would miss, or would have to give or write besides."""
    for name, wanted in members["parameters"].items():
        try:
            member = attrgetter(name)(spincheck.engine)
        except AttributeError:
            yield f"{name} is gone"
            continue
        if wanted is None:
            continue
        now = inspect.signature(member).parameters
        if [one for one in now if one in wanted] != wanted:
            yield f"{name} does not take {', '.join(wanted)}"
        for one in now.values():
            if one.name not in wanted and one.default is one.empty:
                yield f"{name} needs {one.name}"
    written = Engine.__abstractmethods__ | Session.__abstractmethods__
    yield from (f"{name} must be written" for name in sorted(written - set(members["written"])))


def test_what_version_1_had_is_there_and_asks_for_no_more() -> None:
    assert list(breaches(MEMBERS)) == []


def longer(self: Session, state: object, timestep: float | None, exactly: bool) -> None:
    """A restart that asks for more."""


def renamed(self: Session, state: object, step: float | None = None) -> None:
    """A restart whose second argument has another name."""


@each_case(
    ("name", "changed", "found"),
    [
        ("restart", longer, "Session.restart needs exactly"),
        ("restart", renamed, "Session.restart does not take self, state, timestep"),
        ("__abstractmethods__", Session.__abstractmethods__ | {"energy"}, "energy must be written"),
    ],
)
def test_a_change_that_breaks_adapters_is_found(name: str, changed: object, found: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Session, name, changed)
        assert list(breaches(MEMBERS)) == [found]


def test_a_name_that_is_gone_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(spincheck.engine, "composed")
    assert list(breaches(MEMBERS)) == ["composed is gone"]


@deprecated("'step' goes in 0.9: use 'advance'")
def step(self: object, steps: int) -> None:
    """A planted deprecated member."""


@each_case("planted", {"method": step, "property": property(step)})
def test_a_deprecated_member_that_is_overridden_warns_and_names_the_replacement(
    planted: object,
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Session, "step", planted, raising=False)
        words = r"Mine\.step: 'step' goes in 0.9: use 'advance'"
        with pytest.warns(DeprecationWarning, match=words) as warned:
            type("Mine", (Session,), {"step": None})
        assert [one.filename for one in warned] == [__file__]
        type("Other", (Session,), {"steps": None})


def test_a_deprecated_member_that_is_used_warns_and_names_the_replacement() -> None:
    with pytest.warns(DeprecationWarning, match=r"'step' goes in 0.9: use 'advance'"):
        step(None, 1)


#: Attributes of scenes that sources read, through their usual name.
READ = re.compile(r"\bscenario\.((?:(?:body|start|constraint|carrier|rotors|window)\.)?\w+)")
#: Adapters, and what they share that reads scenes.
READERS = ("adapters/**/*.py", "child/session.py", "scene_record.py", "world_*.py")


def listed() -> dict[str, str]:
    """The attributes of scenes on the page, by their last two words as sources read them."""
    table = PAGE.partition("A scenario has")[2].partition("\n4. ")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    names = (name for row in rows for name in re.findall(r"`([\w.]+)`", row))
    return dict.fromkeys(name.removeprefix("scenario.") for name in names)


def test_the_adapters_here_read_no_more_of_a_scene_than_the_page_lists() -> None:
    paths = [path for pattern in READERS for path in (ROOT / "engines").glob(pattern)]
    read = {name for path in paths for name in READ.findall(path.read_text(encoding="utf-8"))}
    known = set(listed()) | {name.partition(".")[0] for name in listed()}
    assert len(read) > 10
    assert read - known == set()


@each_case("name", sorted(listed()))
def test_a_scene_has_what_the_page_lists(name: str) -> None:
    attrgetter(name)(library_scene("fast-top"))


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Install a package `another_engine` of this source."""

    def installed(source: str, member: str = "") -> None:
        (tmp_path / "another_engine.py").write_text(source, encoding="utf-8")
        info = tmp_path / "another_engine-1.0.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text("Name: another-engine\nVersion: 1.0\n", encoding="utf-8")
        points = f"[spincheck.engines]\nanother = another_engine{member}\n"
        (info / "entry_points.txt").write_text(points, encoding="utf-8")
        monkeypatch.syspath_prepend(str(tmp_path))
        sys.modules.pop("another_engine", None)
        forget()

    yield installed
    forget()


TOY_SOURCE = TOY.read_text(encoding="utf-8")
#: By what is said of an adapter that cannot be used: its source.
UNUSABLE = {
    "toy cannot be used: 'interface' must be 1 to 2, got None: state the version that it is "
    "written for.": TOY_SOURCE.replace("    interface = 1\n", ""),
    "toy cannot be used: 'interface' must be 1 to 2, got 3: it needs a newer spincheck.": (
        TOY_SOURCE.replace("interface = 1", "interface = 3")
    ),
    "another_engine cannot be used: importing it failed: cannot import name 'Later' from "
    "'spincheck.engine': this spincheck has its version 2.": (
        TOY_SOURCE.replace("import BodyReading", "import Later, BodyReading")
    ),
    # What a package may raise, and not only that it lacks another.
    **{
        f"another_engine cannot be used: importing it failed: {error}.": source
        for error, source in {
            "RuntimeError: built for numpy 1": "raise RuntimeError('built for numpy 1')",
            "ZeroDivisionError: division by zero": "1 / 0",
            "SystemExit: 3": "import sys; sys.exit(3)",
            "Panic: in Rust": "class Panic(BaseException): ...\nraise Panic('in Rust')",
        }.items()
    },
}


@each_case(("line", "source"), [*UNUSABLE.items()])
def test_an_adapter_that_cannot_be_used_gets_one_line_and_costs_only_itself(
    line: str, source: str, install: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    install(source)
    names = [engine.name for engine in choose([], [], []).engines]
    assert "mujoco" in names
    assert "toy" not in names
    said = [one for one in capsys.readouterr().err.splitlines() if "cannot be used" in one]
    assert said == [line]


def test_an_engine_that_spincheck_depends_on_is_missing_with_how_to_get_it() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wheels = {re.split("[>=;]", line)[0]: line for line in project["dependencies"]}
    adapters = {path.name for path in (ROOT / "engines/adapters").iterdir()}
    assert {*HOW} == {*wheels} & adapters
    absent = discovery._missing("pybullet", ModuleNotFoundError(name="pybullet"))
    assert absent.reason == f"the package 'pybullet' is not installed; {HOW['pybullet']}"
    # Where there is a wheel.
    for word, key in (("Linux", "linux"), ("x86-64", "x86_64"), ("3.11", "'3.11'")):
        assert (word in HOW["pybullet"], key in wheels["pybullet"]) == (True, True)


RULE = (
    "its entry point must be a module that defines a complete subclass of spincheck.engine.Engine"
)


@each_case(
    ("source", "member"),
    [
        ("not_one = 3", ""),
        ("not_one = 3", ":not_one"),
        (TOY_SOURCE, ":Toy"),
        # Without a method that an engine must have.
        (TOY_SOURCE.partition("    def open")[0], ""),
        ("from spincheck.engines.adapters.mujoco import MuJoCo", ""),
    ],
)
def test_an_entry_point_of_no_engine_is_listed_with_what_is_wrong(
    source: str, member: str, install: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    install(source, member)
    code, out, _ = ended("engines")
    line = f"another cannot be used: {RULE}, got 'another_engine{member}'."
    assert (code, line in " ".join(out.split())) == (0, True)
    code, _, err = ended("run", "fast-top", "--engine", "another")
    assert (code, f"engine 'another' cannot be used: {RULE}" in " ".join(err.split())) == (3, True)


def test_ctrl_c_while_engines_are_imported_is_no_fault_of_theirs(
    install: Callable[..., None],
) -> None:
    install("raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        discovery.engines()


def test_a_module_that_finds_its_engines_itself_may_find_none(
    install: Callable[..., None],
) -> None:
    install("def discovered():\n    return []\n")
    assert "another" not in {one.name for one in discovery.missing()}


def test_one_that_is_too_old_is_told_so() -> None:
    words = "'protocol' must be 2 to 3, got 1: it needs an older spincheck, or a newer version of"
    assert misfit("protocol", 1, oldest=2, newest=3).startswith(words)
    assert not any(misfit("protocol", stated, oldest=2, newest=3) for stated in (2, 3))


def test_an_engine_named_as_another_ends_commands_with_one_message(
    install: Callable[[str], None],
) -> None:
    install(TOY_SOURCE.replace('name = "toy"', 'name = "mujoco"'))
    named = r"named 'mujoco', .* and another_engine"
    with pytest.raises(discovery.NameTaken, match=named) as taken:
        discovery.engines()
    complaint = refusal(taken.value)
    assert complaint is not None
    assert complaint.exit_code == NOT_RUN
