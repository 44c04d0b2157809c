"""Runs and verdicts in lines of eighty columns, whose numbers are whole."""

from dataclasses import replace

import pytest
from made_up import MadeUp, at_stock, results
from spincheck.reports.cli.run.summary import WIDTH, run_lines, verdict_lines
from spincheck.reports.results.records import Key, Row
from spincheck.scenarios import SIGNALS, Errors

LONG = "a-scene-with-a-name-of-more-than-the-columns-there-are-for-one"
TINY = Errors(*(k * 1.1e-99 for k in range(1, len(SIGNALS) + 1)))
ROW = Row(Key(LONG, "an-engine", "a-method"), "1", 1.2345e-300, "ok", errors=TINY)


def everything() -> tuple[list[str], list[str]]:
    stored = at_stock(results(methods=(MadeUp("e" * 30, "m" * 30, 1), MadeUp("e", "m", 4))))
    rows = [replace(row, reason="because " * 40) for row in stored.rows]
    verdicts = [replace(v, verdict="disagrees", quoted="because " * 80) for v in stored.verdicts]
    return list(run_lines([*rows, ROW])), list(verdict_lines(verdicts))


@pytest.mark.parametrize("lines", everything(), ids=["rows", "verdicts"])
def test_no_line_is_wider_than_a_terminal(lines):
    assert lines
    assert [line for line in lines if len(line) > WIDTH] == []


def test_no_exponent_is_cut_and_without_errors_it_says_how_and_when_a_run_ended():
    diverged = replace(ROW, outcome="diverged", errors=None, stopped_at=0.25)
    # That at a stock timestep is marked.
    _, _, *lines = run_lines([ROW, replace(diverged, stock=True)])
    assert [line[0] for line in lines] == [" ", "*"]
    assert lines[0].split() == ["1.2345e-300", *(f"{error:.1e}" for _, error in TINY)]
    assert "diverged at 0.25 s" in lines[1]


def test_what_is_not_as_it_should_be_has_its_reason():
    stored = results(methods=(MadeUp("e", "m", 1, "disagrees", "settles elsewhere"),))
    text = "\n".join(verdict_lines(stored.verdicts))
    assert "settles elsewhere" in text
