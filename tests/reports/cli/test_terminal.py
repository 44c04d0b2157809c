"""Tables on a narrow terminal: nothing is wider, and no number is cut."""

import shlex
from pathlib import Path
from typing import Any

import pytest
import rich.console
from spincheck.reports.cli import terminal

WIDTH = 80
NUMBERS = ("-1.9189156e-17", "6.02214076e+23", "0.00031622776601683794")


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal of eighty columns; what is printed is captured."""
    plain = rich.console.Console

    def console(**options: Any) -> rich.console.Console:
        return plain(**options, force_terminal=True, width=WIDTH, color_system=None)

    monkeypatch.setattr(rich.console, "Console", console)


def printed(rows: list[dict[str, object]], capsys: pytest.CaptureFixture[str]) -> str:
    terminal.table(rows)
    return capsys.readouterr().out


def test_a_command_to_copy_is_quoted() -> None:
    words = terminal.command("report", Path("a dir é/r s.sqlite"))
    assert shlex.split(words) == ["spincheck", "report", "a dir é/r s.sqlite"]
    assert terminal.command("run", Path("my-top.toml")) == "spincheck run my-top.toml"


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("columns", [1, 3, 8])
def test_on_a_terminal_no_line_is_wider_and_no_number_is_cut(
    columns: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """Eight such columns do not fit side by side: each record is a paragraph."""
    row: dict[str, object] = {f"column {k}": NUMBERS[k % 3] for k in range(columns)}
    row["why"] = "a long reason in words that go on " * 4
    row["scene"] = "chaos-beyond-the-horizon"
    text = printed([row, row], capsys)
    assert max(map(len, text.split("\n"))) <= WIDTH
    for k in range(columns):
        assert text.count(NUMBERS[k % 3]) >= 2
    assert "…" not in text


def test_in_a_pipe_a_record_is_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    row: dict[str, object] = {str(k): number for k, number in enumerate(NUMBERS * 4)}
    lines = printed([row, row], capsys).strip().split("\n")
    assert sum(NUMBERS[0] in line for line in lines) == 2


def test_the_time_left_rests_on_what_finished_last() -> None:
    """The first took a minute to start; the others two seconds each."""
    finished = [60.0, 62.0, 64.0, 66.0, 68.0]
    assert terminal._left(finished, 15) == ", 20 s left"
    assert terminal._left(finished[:1], 15) == ""
    busier = [*finished, 78.0, 88.0, 98.0]
    assert terminal._left(busier, 15) == ", 56 s left"
