"""The known issues: the data are well-formed, every command parses, and the page is of them."""

import re
from pathlib import Path

import click
import pytest
import typer
from known_issues import DATA, KnownIssue, known_issues
from spincheck.engines import engines
from spincheck.reports.cli.app import app
from spincheck.reports.cli.run.encodings import named_encodings
from spincheck.scenarios import LIBRARY

ISSUES = known_issues()
#: Public issues that are known, and how many of them at the least have a command.
KNOWN, LEAST = 80, 50


def parsed(issue: KnownIssue, folder: Path) -> click.Context:
    """The command's own context; click raises if it does not parse."""
    name, *words = issue.words(folder)
    command = typer.main.get_command(app).commands[name]  # type: ignore[attr-defined]
    return command.make_context(name, words)


def check(issue: KnownIssue, folder: Path) -> None:
    assert re.fullmatch(r"https://github\.com/[\w.-]+/[\w.-]+/(issues|pull)/\d+", issue.url)
    assert issue.title
    assert bool(issue.command) != bool(issue.why)
    if not issue.command:
        return
    options = parsed(issue, folder).params
    asked = {name.partition("@")[0] for name in options.get("engine") or ()}
    if issue.engine:
        assert issue.engine in asked
    versions = {name.partition("@")[2] for name in options.get("engine") or () if "@" in name}
    assert versions == set(issue.versions)
    if issue.scene:
        assert list(LIBRARY.rglob(f"{issue.scene}.toml"))
    installed = engines()
    for name in asked & set(installed):
        methods = {method.name for method in installed[name].methods}
        assert set(options.get("method") or ()) <= methods or len(asked) > 1
    named_encodings(options.get("as_encoded") or "")


def test_every_known_issue_is_well_formed_and_its_command_parses(tmp_path):
    assert len({issue.url for issue in ISSUES}) == len(ISSUES) == KNOWN
    assert sum(bool(issue.command) for issue in ISSUES) >= LEAST
    for issue in ISSUES:
        check(issue, tmp_path)


def test_a_command_that_does_not_parse_is_found(tmp_path):
    issue = KnownIssue(
        "https://github.com/a/b/issues/1", "made up", command="run fast-top --enginex"
    )
    with pytest.raises(Exception, match="No such option: --enginex"):
        check(issue, tmp_path)


def test_the_page_has_every_issue():
    page = DATA.with_suffix(".md").read_text(encoding="utf-8")
    assert [issue.url for issue in ISSUES if issue.url not in page] == []
