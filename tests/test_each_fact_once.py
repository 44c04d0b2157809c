"""A new signal is one file to edit, and so is a new verdict's word besides what gives it.

Verified: no file outside of the tables lists their names; and, with one entry more in each table,
everything that shows, stores or bounds the others shows, stores and bounds that one too.
Not verified: that its numbers are right.
"""

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from scene_texts import FAST_TOP
from spincheck.reports.results.verdict_words import RANKS
from spincheck.scenarios import SIGNAL

ROOT = Path(__file__).parents[1]
TOPS = ("scenarios", "reference", "engines", "reports")
#: What spells so many names of a table in one place lists them. The com, its velocity and spins are
#: of a body's state too, so they are not counted.
LISTS = 3
NAMES = {"signal": set(SIGNAL) - {"com", "velocity", "spins"}, "word": set(RANKS)}
#: Where a new name is added.
TABLES = {"signal": "scenarios/signals.py", "word": "reports/results/verdict_words.py"}
#: Files that spell names for a reason of their own: a new name leaves them as they are.
REASONS = {
    "reports/harness/comparison/rows.py": "turns until 1°, errors a turn, a blown-up energy",
    "reports/pages/scene/default_tables.py": "three columns chosen for a narrow table",
    "reports/pages/scene/scene_answer.py": "three columns chosen for a narrow table",
    "reports/harness/judging/verdict.py": "gives verdicts, and reads outcomes of runs",
    "reports/harness/gradients/compared.py": "gives verdicts on derivatives",
    "reports/harness/gradients/study.py": "gives verdicts on derivatives",
    "reports/harness/gradients/verdict.py": "gives verdicts on derivatives",
    "reports/results/reasons.py": "the sentences of three words",
    "reports/pages/overview/protocol.md": "the rule by which a method disagrees, in words",
    "reports/pages/templates/style.css": "outcomes of runs, in the colours of verdicts",
}


def names_in(kind: str, name: str, text: str) -> list[set[str]]:
    """The words of a source; of Python, by function, class and statement, what each spells."""
    if not name.endswith(".py"):
        return [set(re.findall(r"\w+", text))]
    return [spelled_in(statement, kind) for statement in ast.parse(text).body]


def spelled_in(statement: ast.stmt, kind: str) -> set[str]:
    """Its strings; of signals also attributes, keywords and fields, which name no other things."""
    spelled = set()
    for node in ast.walk(statement):
        match node:
            case ast.Constant(value=str(value)):
                spelled.add(value)
            case ast.Attribute(attr=value) | ast.keyword(arg=str(value)) if kind == "signal":
                spelled.add(value)
            case ast.AnnAssign(target=ast.Name(id=value)) if kind == "signal":
                spelled.add(value)
    return {word.removesuffix("_error") for word in spelled}


def listing(kind: str, sources: dict[str, str]) -> set[str]:
    """The files that list the names of a table."""
    return {
        name
        for name, text in sources.items()
        if any(len(NAMES[kind] & spelled) >= LISTS for spelled in names_in(kind, name, text))
    }


def all_sources() -> dict[str, str]:
    files = (path for top in TOPS for path in (ROOT / top).rglob("*"))
    return {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for path in files
        if path.suffix in {".py", ".js", ".css", ".html", ".md"}
    }


SOURCES = all_sources()


@pytest.mark.parametrize("kind", NAMES)
def test_only_the_table_lists_its_names(kind):
    assert listing(kind, SOURCES) - REASONS.keys() == {TABLES[kind]}


def test_every_reason_is_of_a_file():
    assert REASONS.keys() <= SOURCES.keys()


@pytest.mark.parametrize(
    ("kind", "name", "text"),
    [
        ("signal", "a.py", 'ERRORS = ("omega", "attitude", "energy")'),
        ("signal", "a.py", "row(omega_error=e.omega, attitude_error=e.attitude, L=e.energy)"),
        ("signal", "a.py", "class Errors:\n omega: int\n attitude: int\n energy: int"),
        ("signal", "a.js", "const SIGNALS = ['attitude', 'omega', 'energy'];"),
        ("word", "a.py", 'RANKS = {"converges": 3, "unresolved": 2, "failed": 0}'),
        ("word", "a.css", ".converges {} .disagrees {} .failed {}"),
    ],
)
def test_a_list_that_is_planted_is_found(kind, name, text):
    assert listing(kind, {name: text}) == {name}


#: Where an entry is put, and the entry.
NEW_SIGNAL = {
    "    spins: Distance | None = None\n": """    spins: Distance | None = None
    upright: Distance | None = None
""",
    "        exists=lambda scene: bool(scene.rotors),\n    ),\n": """\
        exists=lambda scene: bool(scene.rotors),
    ),
    Signal(
        name="upright",
        label="Lz",
        quantity="vertical angular momentum",
        formula="max |Lz_e − Lz_r| / (1 s × the base of the energy)",
        kind="scalar",
        values=lambda scene, motion: angular_momentum_world(scene, motion)[:, 2],
        base=energy_base,
    ),
""",
}
NEW_WORD = {
    '"disagrees", "failed"]': '"disagrees", "failed", "hopeless"]',
    ")\n#: The kinds by their words": """    VerdictKind(
        "hopeless",
        sign="†",
        phrases=("is hopeless", "are hopeless"),
        meaning="nothing helps",
        light=("#000001", "#ffffff"),
        dark=("#000002", "#ffffff"),
        fails=True,
    ),
)
#: The kinds by their words""",
}


#: Run by every Python process that has its folder on the path: it puts edited modules first.
SITE_CUSTOMIZE = """import sys
from importlib.util import spec_from_file_location

class Edited:
    FILES = {files!r}

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return spec_from_file_location(name, cls.FILES[name]) if name in cls.FILES else None

sys.meta_path.insert(0, Edited)
"""


@pytest.fixture(scope="module")
def with_one_more(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene, and tables that have one entry more.

    The scene expects what no run keeps of the new signal.
    """
    folder = tmp_path_factory.mktemp("one-more")
    files = {}
    for kind, entries in (("signal", NEW_SIGNAL), ("word", NEW_WORD)):
        text = SOURCES[TABLES[kind]]
        for old, new in entries.items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        edited = folder / Path(TABLES[kind]).name
        edited.write_text(text, encoding="utf-8")
        module = TABLES[kind].removesuffix(".py").replace("/", ".")
        files[f"spincheck.{module}"] = str(edited)
    customize = SITE_CUSTOMIZE.replace("{files!r}", repr(files))
    (folder / "sitecustomize.py").write_text(customize, encoding="utf-8")
    expect = '[[expect]]\nengine = "mujoco"\nmethod = "RK4"\ntimestep = 0.001\nupright = 1e-30\n'
    (folder / "top.toml").write_text(FAST_TOP + expect, encoding="utf-8")
    return folder


PROGRAM = """
import json, sys
from command_line import spincheck
done = [spincheck(*words) for words in json.loads(sys.argv[1])]
print(json.dumps([(one.returncode, one.stdout) for one in done]))
"""


def run(folder: Path, *commands: tuple[str, ...]) -> list[tuple[int, str]]:
    """Exit code and output of each command with the edited tables, all in one other process."""
    paths = os.pathsep.join([str(folder), str(ROOT / "tests/support")])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(commands)],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [(code, output) for code, output in json.loads(done.stdout)]


@pytest.mark.processes
@pytest.mark.slow
def test_one_entry_more_in_the_tables_is_all_that_a_new_name_takes(with_one_more):
    done = run(
        with_one_more,
        ("run", "top.toml", "--engine", "mujoco", "--method", "RK4", "--out", "r.sqlite", "--json"),
        ("rows", "r.sqlite", "--csv"),
        ("recommend", "top.toml", "--upright", "1e-3", "--from", "r.sqlite", "--json"),
        ("report", "r.sqlite", "--out", "pages"),
    )
    assert [code for code, _ in done] == [1, 0, 0, 1]
    ran, rows, recommended = json.loads(done[0][1]), done[1][1], json.loads(done[2][1])
    finished = [row for row in ran["rows"] if row["outcome"] == "ok"]
    assert all(row["upright_error"] > 0 for row in finished)
    (verdict,) = ran["verdicts"]
    assert verdict["verdict"] == "converges"
    assert any("Lz error" in unmet for unmet in verdict["unmet"])
    assert "upright_error" in rows
    assert recommended["checks"][-1]["upright"] <= 1e-3
    pages = with_one_more / "pages"
    first, scene = (
        (pages / name).read_text(encoding="utf-8") for name in ("index.html", "scenes/top.md")
    )
    assert 'value="upright"' in first
    assert "† hopeless" in first
    assert "| Lz error, relative |" in scene
    assert "td.hopeless" in (pages / "assets" / "style.css").read_text(encoding="utf-8")
