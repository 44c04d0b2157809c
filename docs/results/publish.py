"""Runs scenes and writes dated pages of every engine's version: `make results`.

A page and a JSON file a version go to docs/results/DATE, the report with a page a scene to
build/results/DATE. What was written on other days stays, and is in the history of index.md.
"""

import argparse
import json
import math
import subprocess
from datetime import date
from pathlib import Path
from statistics import median
from typing import Any

import spincheck
from spincheck.reports.results.verdict_words import RANKS

FOLDER = Path(__file__).parent
BUILD = FOLDER.parents[1] / "build" / "results"
#: Older versions that the default run is compared with, and the scenes on which.
VERSIONS = ("mujoco@3.3.7", "mujoco@3.6.0", "mujoco@3.10.0", "pybullet@3.2.6")
COMPARED = ("fast-top", "tennis-racket", "book-with-drag")
COLUMNS = ("method", *RANKS, "attitude off, median", "attitude off, worst", "worst on")
HEAD = """# Results by date and version

Each page is what one version of an engine did on the scenes that its JSON file names, with a line a
method; the file has every verdict with its reason. Attitudes are off by so much at the timestep
that users of the engine get who set none. Methods other than `default` are the engine with what a
scene does not call for switched off. [How to object](../project/neutrality.md).

`make results` writes these pages, and the report with a page a scene into `build/results`.
"""

Record = dict[str, Any]


def run(scenes: list[str], options: list[str], out: Path) -> None:
    """Run scenes; that something disagrees is a result."""
    done = subprocess.run(["spincheck", "run", *scenes, *options, "--out", out], check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(f"'spincheck run' ended with exit code {done.returncode}")


def records(stored: Any, day: str) -> list[Record]:
    """What each version of each engine did, as its JSON file has it."""
    versions = {(row.key.engine, row.engine_version) for row in stored.rows}
    return [record(stored, *names, day) for names in sorted(versions)]


def record(stored: Any, engine: str, version: str, day: str) -> Record:
    """What one version did; an engine at an older version is named `engine@version` in results."""
    verdicts = [one for one in stored.verdicts if one.key.engine == engine]
    # Methods are run at 1 ms, too; an engine's own timestep is no shorter, and comes last.
    rows = sorted(
        (one for one in stored.rows if one.key.engine == engine and one.stock),
        key=lambda one: one.timestep,
    )
    return {
        "engine": engine.partition("@")[0],
        "version": version,
        "date": day,
        "scenes": sorted({one.key.scenario for one in verdicts}),
        "verdicts": sorted(
            [one.key.method, one.key.scenario, one.verdict, one.reason] for one in verdicts
        ),
        "degrees_off": {
            f"{one.key.method} {one.key.scenario}": math.degrees(one.errors["attitude"])
            if one.errors
            else None
            for one in rows
        },
    }


def line(one: Record, method: str) -> list[str]:
    """A method's line of the table: how many verdicts of each word, and errors."""
    words = [word for name, _, word, _ in one["verdicts"] if name == method]
    off = {
        key.split()[1]: math.inf if degrees is None else degrees
        for key, degrees in one["degrees_off"].items()
        if key.split()[0] == method
    }
    shown = [median(off.values()), max(off.values())] if off else []
    cells = [
        f"{float(f'{degrees:.2g}'):g}°" if degrees < math.inf else "blew up" for degrees in shown
    ]
    counts = [str(words.count(word) or "") for word in RANKS]
    worst_on = max(off, key=lambda name: off[name], default="–")
    return [method, *counts, *(cells or ["–", "–"]), worst_on]


def table(columns: tuple[str, ...], lines: list[list[str]]) -> str:
    """A table in Markdown."""
    rows = [columns, ["---"] * len(columns), *lines]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows) + "\n"


def name_of(one: Record) -> str:
    """The name of its files, without the ending."""
    return f"{one['engine']}-{one['version'].split()[0]}"


def page(one: Record) -> str:
    """The page of a version."""
    methods = sorted({name for name, *_ in one["verdicts"]})
    return f"""# {one["engine"]} {one["version"]}, {one["date"]}

On {len(one["scenes"])} scenes; [every verdict with its reason]({name_of(one)}.json).

{table(COLUMNS, [line(one, method) for method in methods])}"""


def index() -> str:
    """The page of all days: a line a version and day, newest first; counts over all methods."""
    paths = sorted(FOLDER.glob("*/*.json"), reverse=True)
    lines = []
    for path in paths:
        one = json.loads(path.read_text(encoding="utf-8"))
        words = [word for _, _, word, _ in one["verdicts"]]
        link = f"[{one['engine']} {one['version']}]({path.parent.name}/{path.stem}.md)"
        counts = [str(words.count(word) or "") for word in RANKS]
        lines.append([one["date"], link, str(len(one["scenes"])), *counts])
    columns = ("date", "engine", "scenes", *RANKS)
    pages = "\n".join(path.relative_to(FOLDER).with_suffix("").as_posix() for path in paths)
    return f"{HEAD}\n{table(columns, lines)}\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"


def main() -> None:
    """Run, and write the pages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", help="scenes or folders; the library if left out")
    parser.add_argument("--quick", action="store_true", help="short ladders, without timing")
    arguments = parser.parse_args()
    day = date.today().isoformat()
    out, folder = BUILD / f"{day}.sqlite", FOLDER / day
    folder.mkdir(parents=True, exist_ok=True)
    BUILD.mkdir(parents=True, exist_ok=True)
    quick = ["--quick"] * arguments.quick
    run(arguments.scenes, quick, out)
    older = [word for version in VERSIONS for word in ("--engine", version)]
    run(list(COMPARED), [*older, "--quick"], out)
    subprocess.run(["spincheck", "report", out, "--out", BUILD / day], check=False)
    for one in records(spincheck.results(out), day):
        (folder / f"{name_of(one)}.md").write_text(page(one), encoding="utf-8")
        text = json.dumps(one, ensure_ascii=False, indent=1)
        (folder / f"{name_of(one)}.json").write_text(text + "\n", encoding="utf-8")
    (FOLDER / "index.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main()
