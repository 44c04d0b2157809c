"""Docs agree with the repository: links lead somewhere, commands and options exist."""

import json
import os
import re
import shlex
import subprocess
import sys
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import pytest
from case_loops import each_case
from spincheck.engines import Cause
from spincheck.reports.cli.app import app
from spincheck.reports.harness.executors.local_workers import TIME_LIMIT
from spincheck.reports.harness.timesteps.stock import STEP_BUDGET
from spincheck.reports.results.verdict_words import VerdictWord
from spincheck.scenarios.scatter import SCATTER
from typer.main import get_group

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
TOPS = ("docs", "engines", "reference", "reports", "scenarios", "tests")
#: Written while the site is built.
MADE = {DOCS / "reference/commands.md"}
PAGES = sorted({*DOCS.rglob("*.md"), *ROOT.glob("*.md")} - MADE)
TEXTS = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in PAGES}
#: A path below docs/ that a text or a source names.
NAMED = re.compile(r"(?<![\w/.-])docs/[\w/-]+\.(?:md|yml|png)\b")


def links(text: str) -> list[str]:
    """Targets of links to files; code is left out."""
    text = re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)
    return [link for link in re.findall(r"\]\(([^)\s#]+)", text) if "://" not in link]


def commands(text: str) -> list[list[str]]:
    """Calls of spincheck in the blocks of shell commands, a list of words each."""
    blocks = re.findall(r"```(?:sh|\{code-cell\}\n%%bash)\n(.*?)```", text, flags=re.DOTALL)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    found = [line for line in lines if re.match(r"\s*spincheck [a-z]", line)]
    return [shlex.split(re.split(r" \|\| | > | 2>|; ", line)[0], comments=True) for line in found]


def make_targets(text: str) -> set[str]:
    return set(re.findall(r"(?:^|`)make ([\w-]+)", text, flags=re.MULTILINE))


def test_there_are_pages_links_and_commands() -> None:
    assert {"report", "test", "docs"} <= make_targets(TEXTS["README.md"])
    assert make_targets(TEXTS["CONTRIBUTING.md"])
    assert len(TEXTS) > 50
    assert sum(len(links(text)) for text in TEXTS.values()) > 100
    assert sum(len(commands(text)) for text in TEXTS.values()) > 50


@each_case("name", sorted(TEXTS))
def test_every_link_leads_somewhere(name: str) -> None:
    folder = (ROOT / name).parent
    targets = {link: (folder / link).resolve() for link in links(TEXTS[name])}
    assert [k for k, path in targets.items() if not path.exists() and path not in MADE] == []


def test_every_page_is_in_a_table_of_contents() -> None:
    pages = {page.relative_to(DOCS).with_suffix("").as_posix() for page in DOCS.rglob("*.md")}
    listed = {"index"}
    for index in DOCS.rglob("index.md"):
        folder = index.parent.relative_to(DOCS).as_posix().removeprefix(".")
        trees = re.findall(r"```\{toctree\}\n(.*?)```", index.read_text("utf-8"), re.DOTALL)
        names = [name for tree in trees for name in tree.split() if not name.startswith(":")]
        listed |= {f"{folder}/{name}".removeprefix("/") for name in names}
    assert pages - listed == set()


@each_case("name", sorted(TEXTS))
def test_every_command_has_the_options_that_are_shown(name: str) -> None:
    check_options(commands(TEXTS[name]))


@each_case("name", sorted(TEXTS))
def test_every_make_target_that_is_shown_exists(name: str) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert make_targets(TEXTS[name]) <= set(re.findall(r"^([\w-]+):", makefile, flags=re.MULTILINE))


def test_every_verdict_is_explained_to_newcomers() -> None:
    explained = re.findall(r"^\| (\w+) \|", TEXTS["README.md"], flags=re.MULTILINE)
    assert set(explained) - {"verdict"} == set(get_args(VerdictWord))


@pytest.mark.parametrize(
    "words",
    [
        f"more than {STEP_BUDGET:,} steps".replace(",", " "),
        f"hang of more than {TIME_LIMIT:g} s",
        f"times exp({SCATTER:g} n)",
    ],
)
def test_numbers_of_ensembles_are_those_of_the_code(words):
    assert words in " ".join(TEXTS["docs/how-to/ensembles.md"].split())


THRESHOLDS = TEXTS["docs/measured/thresholds.md"]
PROTOCOL = (ROOT / "reports/pages/overview/protocol.md").read_text(encoding="utf-8")


def test_reports_say_what_the_table_of_smallest_faults_has() -> None:
    sizes = [line.split("|")[4].strip() for line in THRESHOLDS.splitlines() if " order |" in line]
    assert sizes.count("1e-08") > len(sizes) / 2
    assert "most are found from a relative size of 10⁻⁸ on" in PROTOCOL


def test_no_kind_of_fault_goes_undetected() -> None:
    assert "| never |" not in THRESHOLDS
    assert THRESHOLDS.count("| fourth order |") > 1


def test_the_page_has_a_row_for_every_cause() -> None:
    table = TEXTS["docs/explanation/outcomes.md"].split("## Causes")[1].split("\n##")[0]
    first_cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    documented = {cause for cell in first_cells for cause in re.findall(r"`([^`]+)`", cell)}
    assert documented == set(get_args(Cause)) - {""}


def check_options(calls: list[list[str]]) -> None:
    group = get_group(app)
    for words in calls:
        command = group.get_command(None, words[1])  # type: ignore[arg-type]
        assert command is not None, words
        own = words[: words.index("--")] if "--" in words else words
        context = command.make_context(words[1], [], resilient_parsing=True)
        options = {option for parameter in command.get_params(context) for option in parameter.opts}
        shown = {word.partition("=")[0] for word in own if re.match(r"--?[a-z]", word)}
        assert shown <= options, words


def test_every_page_that_sources_name_exists() -> None:
    sources = [path for top in TOPS for path in (ROOT / top).rglob("*.*")]
    named = {
        (path.relative_to(ROOT).as_posix(), name)
        for path in sources
        if path.suffix in (".py", ".mjs", ".md", ".toml", ".html")
        for name in NAMED.findall(path.read_text(encoding="utf-8"))
    }
    assert len(named) > 20
    assert {(source, name) for source, name in named if not (ROOT / name).exists()} == set()


@pytest.fixture(scope="module")
def publish() -> ModuleType:
    """What `make results` runs."""
    spec = spec_from_file_location("publish", DOCS / "results/publish.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def results() -> dict[Path, dict[str, Any]]:
    paths = sorted((DOCS / "results").glob("*/*.json"))
    assert paths
    return {path: json.loads(path.read_text(encoding="utf-8")) for path in paths}


def test_pages_of_results_are_those_of_their_data(publish: ModuleType) -> None:
    """What `make results` would write of the JSON files that are there."""
    for path, record in results().items():
        assert path.read_text(encoding="utf-8") == publish.as_json(record)
        assert path.with_suffix(".md").read_text(encoding="utf-8") == publish.page(record)
    assert (DOCS / "results/index.md").read_text(encoding="utf-8") == publish.index()


def test_no_page_of_results_is_there_whose_verdicts_a_newer_one_has(publish: ModuleType) -> None:
    """And a page with other scenes or methods stays: the newest is then no more than a part."""
    for record in results().values():
        assert publish.superseded(record) == []
    path, newest = max(results().items(), key=lambda item: item[1]["date"])
    later = newest | {"date": "9999-01-01"}
    assert path in publish.superseded(later)
    assert path not in publish.superseded(later | {"verdicts": newest["verdicts"][1:]})


def test_a_version_is_shown_the_known_issues_that_it_has(publish: ModuleType) -> None:
    """And only those; RK4's attitude was mended in 4.0.0, which its errors show."""
    rk4 = {}
    for record in results().values():
        lines = publish.faults(record)
        commands_shown = re.findall(r"`(spincheck [^`]*)`", str(lines))
        check_options([shlex.split(call) for call in commands_shown])
        if record["engine"] == "mujoco":
            averaged = any("are averaged" in line for line in lines)
            assert averaged == (publish.ordered(record["version"]) < [4])
            rk4[averaged] = record["degrees_off"]["RK4 fast-top"]
    assert rk4[True] > 1000 * rk4[False]


def test_a_run_that_was_not_made_is_not_called_one_that_blew_up(publish: ModuleType) -> None:
    """It has no error; one that blew up has, and an error is none."""
    verdicts = [["RK4", scene, "converges", "[1, 2], [3]"] for scene in ("a", "b", "c")]
    off = {"RK4 a": 0.5, "RK4 b": None}
    record = {"engine": "mujoco", "version": "4.0.0", "verdicts": verdicts, "degrees_off": off}
    assert publish.scene_lines(record, ["RK4"]) == [["a", "0.5°"], ["b", "blew up"], ["c", ""]]
    assert publish.line(record, "RK4")[-2:] == ["blew up", "b"]
    assert json.loads(publish.as_json(record)) == record


def test_what_is_wrong_would_be_found() -> None:
    assert links("[a](b.md#c), `[d](e)`, [f](https://g)") == ["b.md"]
    assert commands("```sh\nspincheck run a --quick || echo no\n```") == [
        ["spincheck", "run", "a", "--quick"]
    ]
    assert NAMED.findall("see docs/explanation/cost.md.") == ["docs/explanation/cost.md"]


#: Pages whose cells `make docs` alone runs: each takes ten CPU seconds or more.
RUN_BY_MAKE = (
    *("course/09-engines", "course/10-derivatives", "explanation/outcomes", "gallery/ci"),
    *("gallery/defaults", "gallery/engine-in-c", "gallery/ensemble", "gallery/stability-map"),
    *("gallery/version-worse", "gallery/work-precision"),
)


@pytest.mark.slow
@pytest.mark.processes
@pytest.mark.skipif(find_spec("myst_nb") is None, reason="pip install 'spincheck[docs]'")
def test_what_notebooks_are_forked_from_ends_with_the_build(tmp_path: Path) -> None:
    """So it does where it has started other processes, as compiling machine code does."""
    lines = [
        "import subprocess, sys, warm_start",
        "other = [sys.executable, '-c', 'input()']",
        "warm_start.preload = lambda: subprocess.Popen(other, stdin=subprocess.PIPE)",
        f"warm_start.serve({str(tmp_path / 'made' / 'socket')!r})",
    ]
    (tmp_path / "made").mkdir()
    begun = subprocess.Popen(
        [sys.executable, "-c", "\n".join(lines)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(DOCS / "extensions")},
        text=True,
    )
    assert begun.stdout is not None
    assert begun.stdout.readline() == "ready\n"
    try:
        begun.communicate(timeout=TIME_LIMIT)
    finally:
        begun.kill()
    assert begun.returncode == 0


def test_the_site_is_built_without_a_warning_and_fetches_nothing(tmp_path: Path) -> None:
    """Examples run while it is built, all but `RUN_BY_MAKE`; a cell that fails, fails it."""
    assert all((DOCS / f"{page}.md").exists() for page in RUN_BY_MAKE)
    # Not side by side: of two kernels that are given the same port, one dies
    # (jupyter/jupyter_client#487).
    build = (sys.executable, "-m", "sphinx", "--fail-on-warning", "-q")
    # The language of a page's cells is known once they run.
    build += ("-D", "suppress_warnings=myst-nb.lexer")
    left_out = {"SPINCHECK_CELLS_NOT_RUN": " ".join(f"{page}.md" for page in RUN_BY_MAKE)}
    done = subprocess.run(
        [*build, DOCS, tmp_path],
        env=os.environ | left_out,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    fetched = re.compile(r"<(?:script|img|iframe|link)[^>]+(?:src|href)=\"(?:https?:)?//[^\"]+")
    pages = {page.name: page.read_text(encoding="utf-8") for page in tmp_path.rglob("*.html")}
    assert len(pages) > 60
    assert {name: found for name, text in pages.items() if (found := fetched.findall(text))} == {}
    index = (tmp_path / "searchindex.js").read_text(encoding="utf-8")
    assert "kovalevskaya" in index.lower()
