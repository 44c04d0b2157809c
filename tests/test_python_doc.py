"""Every example of the page about the Python interface runs, and the loop of judge.md."""

import re
import subprocess
import sys
from pathlib import Path

import command_line
import pytest
import spincheck

DOCS = Path(__file__).parents[1] / "docs"
PAGE = "reference/python.md"


def examples(page):
    return re.findall(r"```python\n(.*?)```", (DOCS / page).read_text("utf-8"), flags=re.DOTALL)


EXAMPLES = examples(PAGE)


@pytest.mark.processes
def test_every_example_runs(tmp_path):
    """One after the other, each with names of its own."""
    program = "".join(f"exec({text!r}, {{'__name__': '__main__'}})\n" for text in EXAMPLES)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert len(EXAMPLES) > 3


def test_the_page_names_what_is_exported():
    text = (DOCS / PAGE).read_text("utf-8")
    assert all(f"spincheck.{name}(" in text for name in spincheck.__all__)


@pytest.mark.processes
def test_the_loop_of_ten_lines_is_judged(tmp_path):
    (loop,) = examples("how-to/judge.md")
    command_line.spincheck("export", "fast-top", ".", cwd=tmp_path)
    subprocess.run([sys.executable, "-c", loop], cwd=tmp_path, check=True)
    judged = command_line.spincheck("judge", "fast-top", "motion.csv", cwd=tmp_path)
    assert (judged.returncode, "within 1°" in judged.stdout) == (0, True)
