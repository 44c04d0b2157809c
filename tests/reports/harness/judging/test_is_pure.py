"""Judging sees records alone: no engine, no exact motion, no file."""

import ast

from spincheck.reports.harness import judging
from spincheck.reports.results import fingerprints

ROOM = "reports.harness.judging"
#: What it may import, besides its own modules: records, signals, and what is a number or a word.
ALLOWED = (
    "reports.results",
    "reports.harness.timesteps.ladder",
    "scenarios",
)


def outside(file, package=ROOM):
    """What a module of the room imports that it may not."""
    names = set(fingerprints._imported(file, package))
    return {name for name in names if not name.startswith((ROOM, *ALLOWED))}


def modules():
    (folder,) = judging.__path__
    return sorted(fingerprints.Path(folder).glob("*.py"))


def test_judging_imports_neither_engines_nor_the_exact_motion(tmp_path):
    assert len(modules()) > 4
    assert {file.name: outside(file) for file in modules() if outside(file)} == {}
    file = tmp_path / "judging.py"
    file.write_text("from ....engines.engine import Engine\n")
    assert outside(file) == {"engines.engine"}


def test_judging_opens_no_file():
    calls = {
        (file.name, node.func.id)
        for file in modules()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not {name for _, name in calls} & {
        "open",
        "open_store",
        "run_rungs",
        "examine_or_refuse",
    }
