"""Digests change when something changes that results depend on, and only then."""

import ast
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from scene_texts import FAST_TOP
from spincheck.engines import engines
from spincheck.engines.adapters.mujoco import MuJoCo
from spincheck.engines.child.engine import ChildEngine
from spincheck.engines.child.messages import Hello
from spincheck.engines.versions.engine import VersionedEngine
from spincheck.engines.versions.folders import folder_of
from spincheck.reports.results import fingerprints, sources
from spincheck.scenarios import loads
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
NAME = "mujoco@3.3.0"
ADAPTERS = ("mujoco", "pybullet")
ADDED = ("\nfrom ", "\nCHANGED = 1\nfrom ")
LOST = ("LOST = 0.1", "LOST = 0.2")
ABSURD = ("ABSURD_ENERGY = 10.0", "ABSURD_ENERGY = 9.0")
#: By file a change of a value in it, and which kinds of results rest on it.
CHANGES = {
    "engines/adapters/pybullet/engine.py": (ADDED, {"pybullet"}),
    "reports/harness/judging/ladder_end.py": (("GOAL = 1e-9", "GOAL = 1e-8"), {"verdict"}),
    "reports/harness/measuring/replay.py": (LOST, {"run"}),
    "reports/results/evidence.py": (("LEVEL = 1e-9", "LEVEL = 1e-8"), {"run", "verdict"}),
    "reports/harness/comparison/rows.py": (ABSURD, {"run", "verdict"}),
    "reports/harness/costs/timing.py": (ADDED, {"timing"}),
    "reference/lagrange.py": (ADDED, {"motion", "run"}),
    "reports/pages/render.py": (ADDED, set()),
    "reports/cli/app.py": (ADDED, set()),
    "reports/results/store.py": (ADDED, set()),
}


def digest(site: Path) -> str:
    engine = VersionedEngine("mujoco", "3.3.0", MuJoCo.methods, site)
    return next(f.digest for f in fingerprints.fingerprints(SCENES["free"], [engine]) if f.engine)


def test_a_version_under_another_python_is_another_engine_and_in_another_cache_the_same() -> None:
    folder = folder_of(NAME, "cp312")
    assert digest(folder) != digest(folder_of(NAME, "cp311"))
    assert digest(folder) == digest(Path("another-cache") / folder.name)


def forget() -> None:
    for cached in (sources.source, fingerprints._content, fingerprints._imported_by):
        cached.cache_clear()
    for cached in (fingerprints.program, fingerprints.modules, fingerprints.adapter):
        cached.cache_clear()


@pytest.fixture(autouse=True)
def _forgotten() -> Iterator[None]:
    """What was found of changed sources is no other test's."""
    yield
    forget()


def digests(monkeypatch, file: Path | None = None, text: str = "") -> dict[str, str]:
    """All digests, with one file's text taken to be another."""
    forget()
    read = Path.read_bytes
    with monkeypatch.context() as patch:
        changed = {file: text.encode()}
        patch.setattr(Path, "read_bytes", lambda p: changed.get(p.resolve()) or read(p))
        kinds = {kind: fingerprints.program(kind) for kind in fingerprints.DECIDING}
        return kinds | {n: fingerprints.adapter(type(engines()[n])) for n in ADAPTERS}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_reaches_what_rests_on_it(monkeypatch, name):
    (old, new), resting = CHANGES[name]
    file = ROOT / name
    text = file.read_text(encoding="utf-8")
    assert old in text
    before = digests(monkeypatch)
    after = digests(monkeypatch, file, text.replace(old, new, 1))
    assert {kind for kind in before if before[kind] != after[kind]} == resting


KNOWN = '[[known]]\nengine = "e"\nmethod = "m"\nverdict = "disagrees"\nreason = "r"\n'


@pytest.mark.parametrize(
    ("old", "new", "resting"),
    [
        ("made up", "made up too", set()),
        ("samples = 101", "samples = 102", {"motion", "verdict"}),
        ("samples = 101\n", f"samples = 101\n{KNOWN}", {"verdict"}),
    ],
    ids=["its source", "its window", "an expected failure"],
)
def test_a_change_of_a_scene_reaches_what_rests_on_it(old, new, resting):
    before, after = (
        {one.kind: one.digest for one in fingerprints.fingerprints(loads(text, "top"), ())}
        for text in (FAST_TOP, FAST_TOP.replace(old, new))
    )
    assert {kind for kind in before if before[kind] != after[kind]} == resting


def commented(text: str) -> str:
    """Source with other docstrings, comments and layout."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        constant = node.value if isinstance(node, ast.Expr) else None
        # The body of an overload, an Ellipsis, is no docstring.
        if isinstance(constant, ast.Constant) and isinstance(constant.value, str):
            constant.value = f"Changed. {constant.value}"
    return f'"""Another."""\n# A comment\n{ast.unparse(tree)}\n'


def test_docstrings_comments_and_layout_change_nothing(monkeypatch):
    before = digests(monkeypatch)
    files = [*ROOT.glob("reports/harness/*.py"), *ROOT.glob("reference/*.py")]
    files += [*ROOT.glob("engines/adapters/mujoco/*.py"), *ROOT.glob("engines/*.py")]
    changed = {f.resolve(): commented(f.read_text(encoding="utf-8")).encode() for f in files}
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda p: changed.get(p.resolve()) or read(p))
    assert digests(monkeypatch) == before


def test_every_module_that_decides_is_there():
    names = {name for names in fingerprints.DECIDING.values() for name in names}
    names |= {*fingerprints.JUDGING}
    assert [name for name in names if not fingerprints._file(name).is_file()] == []


def adapter_in(folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The digest of the class that `my_engine.py` in a folder has, in a package if it is in one."""
    forget()
    package = "my_package." if (folder / "__init__.py").exists() else ""
    name = f"{package}my_engine"
    with monkeypatch.context() as patch:
        patch.syspath_prepend(folder.parent if package else folder)
        digest = fingerprints.adapter(import_module(name).MyEngine)
    for module in [one for one in sys.modules if one.startswith(("my_", "physics", "deeper"))]:
        del sys.modules[module]
    return digest


@pytest.mark.parametrize("is_package", [False, True])
def test_a_change_of_a_module_beside_a_users_adapter_is_one_of_the_adapter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_package: bool
) -> None:
    """Also of one that only such a module imports; not of one that nothing imports."""
    folder = tmp_path / "my_package"
    folder.mkdir()
    dots = "." if is_package else ""
    if is_package:
        (folder / "__init__.py").touch()
    (folder / "my_engine.py").write_text(
        f"{'from . import physics' if is_package else 'import physics'}\n"
        "class MyEngine:\n    pass\n"
    )
    (folder / "physics.py").write_text(f"def rate():\n    from {dots}deeper import TORQUE\n")
    (folder / "deeper.py").write_text("TORQUE = 1.0\n")
    before = adapter_in(folder, monkeypatch)
    if not is_package:
        (folder / "unused.py").write_text("broken = (\n")
        assert adapter_in(folder, monkeypatch) == before
    (folder / "deeper.py").write_text("TORQUE = 2.0\n")
    changed = adapter_in(folder, monkeypatch)
    assert changed != before
    (folder / "deeper.py").write_text("TORQUE = (\n")
    assert adapter_in(folder, monkeypatch) not in (before, changed)


def test_the_arguments_of_a_program_are_part_of_the_engine(tmp_path: Path) -> None:
    """Files among them count by what they hold, wherever they are."""
    (program := tmp_path / "engine.py").write_text("")
    (moved := tmp_path / "other.py").write_text("")
    method = {"name": "midpoint", "order": 2, "attitude_order": 2, "summary": "s", "effects": []}
    described = {"protocol": 1, "name": "toy", "version": "1.0", "precision": "double"}
    hello = Hello.model_validate(described | {"stock_timestep": None, "methods": [method]})
    long = ChildEngine(["python", "-c", "x = 1;" * 100], hello, sources=[])
    assert long.arguments == long.command
    digests = []
    for words in ([program, "--solver=a"], [moved, "--solver=a"], [program, "--solver=b"]):
        engine = ChildEngine([str(word) for word in words], hello)
        found = fingerprints.fingerprints(SCENES["free"], [engine])
        digests.append(next(one.digest for one in found if one.engine))
    assert digests[0] == digests[1] != digests[2]
