"""Every example of the page about the Python interface runs, and the loop of judge.md."""

import re
import subprocess
import sys
from pathlib import Path

import command_line
import pytest
import spincheck

DOCS = Path(__file__).parents[1] / "docs"


def examples(page):
    return re.findall(r"```python\n(.*?)```", (DOCS / page).read_text("utf-8"), flags=re.DOTALL)


@pytest.mark.processes
@pytest.mark.parametrize("number", range(len(examples("reference/python.md"))))
def test_an_example_runs(tmp_path, number):
    path = tmp_path / "example.py"
    path.write_text(examples("reference/python.md")[number], encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", path], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_the_page_names_what_is_exported():
    text = (DOCS / "reference/python.md").read_text("utf-8")
    assert all(f"spincheck.{name}(" in text for name in spincheck.__all__)


@pytest.mark.processes
def test_the_loop_of_ten_lines_is_judged(tmp_path):
    (loop,) = examples("how-to/judge.md")
    command_line.spincheck("export", "fast-top", ".", cwd=tmp_path)
    subprocess.run([sys.executable, "-c", loop], cwd=tmp_path, check=True)
    judged = command_line.spincheck("judge", "fast-top", "motion.csv", cwd=tmp_path)
    assert (judged.returncode, "within 1°" in judged.stdout) == (0, True)
