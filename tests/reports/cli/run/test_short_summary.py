"""The end of a run on the terminal: the answer, in twenty lines of eighty columns."""

from dataclasses import replace
from pathlib import Path

from made_up import results
from spincheck.reports.cli.run.short_summary import WIDTH, short_summary

FOUND, FILE = results(), Path("other results.sqlite")


def test_it_fits_a_terminal():
    lines = short_summary(FOUND, FILE)
    assert len(lines) <= 20
    assert max(map(len, lines)) <= WIDTH


def test_every_verdict_is_counted_once():
    verdicts = [replace(FOUND.verdicts[0], as_shipped=True), *FOUND.verdicts[1:]]
    shipped = sum(verdict.as_shipped for verdict in verdicts)
    first, *groups = " ".join(short_summary(replace(FOUND, verdicts=verdicts), FILE)).split(".")[:3]
    assert first.endswith(f"{len(verdicts)} verdicts")
    words = [group.partition(": ")[2].split(", ") for group in groups]
    counted = [sum(int(part.split()[1]) for part in parts) for parts in words]
    assert counted == [len(verdicts) - shipped, shipped]


def test_what_fails_is_reported_with_its_reason_and_how_many_more_there_are():
    as_clean = {"expected_failure": False, "as_shipped": False}
    wrong = [
        replace(verdict, verdict="disagrees", quoted="R" * 500, **as_clean)
        for verdict in FOUND.verdicts
    ]
    lines = short_summary(replace(FOUND, verdicts=wrong), FILE)
    key = wrong[0].key
    (first,) = (line for line in lines if line.startswith("Fails: "))
    assert f"Fails: {key.scenario}, {key.engine} {key.method}: disagrees" in first
    more = (
        f"{len(wrong) - 1} more fail: 'spincheck rows 'other results.sqlite' --verdicts' has them"
    )
    assert any(line.startswith(more) for line in lines)
    assert len(lines) <= 20
    # Where nothing fails, nothing is said to.
    good = [replace(verdict, verdict="converges", unmet=()) for verdict in FOUND.verdicts]
    assert not [
        line for line in short_summary(replace(FOUND, verdicts=good), FILE) if "ail" in line
    ]


def test_a_timestep_that_was_asked_for_has_its_errors():
    row = next(row for row in FOUND.rows if row.errors is not None)
    lines = short_summary(FOUND, FILE, [row.timestep])
    name = f"{row.key.scenario} {row.key.engine} {row.key.method} "
    assert any(line.startswith(name) and f"{row.errors.omega:.0e}" in line for line in lines)
    assert max(map(len, lines)) <= WIDTH


def test_a_default_that_failed_and_runs_lost_by_the_machine_are_told():
    shipped = [replace(v, as_shipped=True, verdict="failed") for v in FOUND.verdicts]
    lost = replace(FOUND.rows[0], outcome="failed", cause="killed", errors=None)
    lost = replace(lost, reason="it was killed")
    found = replace(FOUND, verdicts=shipped, rows=[lost, *FOUND.rows[1:]])
    text = "\n".join(short_summary(found, FILE))
    assert f"defaults: failed {len(shipped)}." in text
    assert "1 run lost by the machine's fault: it was killed" in text
    assert "lost" not in "\n".join(short_summary(FOUND, FILE))
