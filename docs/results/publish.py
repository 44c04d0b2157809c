"""Runs the library and writes dated pages of every engine's version: `make results`.

A page and a JSON file a version go to docs/results/DATE, the report with a page a scene to
build/results/DATE. What was written on other days stays, and is in the history of index.md.
"""

import argparse
import json
import math
import subprocess
import tomllib
from datetime import date
from pathlib import Path
from statistics import median
from typing import Any

import spincheck
from spincheck.reports.results.verdict_words import RANKS
from spincheck.scenarios import LIBRARY

FOLDER = Path(__file__).parent
BUILD = FOLDER.parents[1] / "build" / "results"
FAULTS = FOLDER.parent / "measured/known-issues.toml"
#: Older versions that are run beside those installed.
VERSIONS = ("mujoco@3.3.7", "mujoco@3.10.0", "pybullet@3.2.6")
COLUMNS = ("method", "scenes", *RANKS, "median error", "largest error", "on")
HEAD = """# Results by date and version

Each page shows what one version of an engine did on the scenes of the library: its known issues
with what to do about them, and the verdicts and errors of each method. *Error* is that of the
attitude at the timestep that users of the engine get who set none. The method `default` is the
engine as shipped; in the others everything that a scene does not call for is switched off. Ladders
are those of `--quick`: a run without it decides some of what is `unresolved` here. The column
*scenes* is the number of scenes that a method was run on, which are the plain ones where it is
smaller than the page's.
[How to object to a result](../project/neutrality.md).

`make results` writes these pages, and a report with a page for each scene into `build/results`.
"""

Record = dict[str, Any]


def run(engines: list[str], out: Path) -> None:
    """Run the plain and the hard scenes; that something disagrees is a result."""
    words = ["spincheck", "run", LIBRARY, "--quick", *engines, "--out", out]
    done = subprocess.run(words, check=False)
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
        key.split()[1]: math.inf if value is None else value
        for key, value in one["degrees_off"].items()
        if key.split()[0] == method
    }
    shown = [median(off.values()), max(off.values())] if off else []
    cells = [degrees(value) for value in shown]
    counts = [str(words.count(word) or "") for word in RANKS]
    worst_on = max(off, key=lambda name: off[name], default="–")
    return [method, str(len(words)), *counts, *(cells or ["–", "–"]), worst_on]


def faults(one: Record) -> list[str]:
    """The known faults that a version has, an item of a list each."""
    known = tomllib.loads(FAULTS.read_text(encoding="utf-8"))["fault"]
    return [
        f"- **{fault['what']}** ({span(fault)}).\n  What to do: {fault['remedy']}."
        f" Upstream: {upstream(fault)}.\n  Shown by {seen(one, fault)}.\n"
        for fault in known
        if one["engine"] == fault["engine"]
        and ordered(fault["since"]) <= ordered(one["version"])
        and ordered(one["version"]) < ordered(fault.get("before", "999"))
    ]


def ordered(version: str) -> list[int]:
    """A version, such as "3.10.0 (double)", as numbers that sort."""
    return [int(number) for number in version.split()[0].split(".")]


def span(fault: Record) -> str:
    """The versions that have a fault."""
    return f"since {fault['since']}" + f", not in {fault.get('before')}" * ("before" in fault)


def upstream(fault: Record) -> str:
    """What the engine's own project says of a fault."""
    text: str = fault.get("upstream", "none known")
    *_, owner, project, _, number = ("", "", "", *text.split("/"))
    return f"[{owner}/{project}#{number}]({text})" if text.startswith("https:") else text


def seen(one: Record, fault: Record) -> str:
    """The command that shows a fault, and what this version did."""
    shown = f"`spincheck {fault['command']}`"
    if "scene" not in fault:
        return shown
    off = one["degrees_off"].get(f"{fault['method']} {fault['scene']}")
    return f"{shown}; here `{fault['method']}` on {fault['scene']}: {degrees(off)}"


def degrees(off: float | None) -> str:
    """An error in words; none is of a run that did not end."""
    return "blew up" if off is None or off == math.inf else f"{float(f'{off:.2g}'):g}°"


def newest(path: Path) -> tuple[str, str, list[int]]:
    """The day, engine and version of a file, to sort by."""
    engine, _, version = path.stem.rpartition("-")
    return path.parent.name, engine, ordered(version)


def table(columns: tuple[str, ...], lines: list[list[str]]) -> str:
    """A table in Markdown, of the columns that are not empty."""
    full = [number for number in range(len(columns)) if any(cells[number] for cells in lines)]
    lines = [[cells[number] for number in full] for cells in (columns, *lines)]
    rows = [lines[0], ["---"] * len(full), *lines[1:]]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows) + "\n"


def name_of(one: Record) -> str:
    """The name of its files, without the ending."""
    return f"{one['engine']}-{one['version'].split()[0]}"


def page(one: Record) -> str:
    """The page of a version."""
    methods = sorted({name for name, *_ in one["verdicts"]})
    return f"""# {one["engine"]} {one["version"]}, {one["date"]}

## Known issues

{"".join(faults(one))}
## On {len(one["scenes"])} scenes

[Every verdict with its reason]({name_of(one)}.json).

{table(COLUMNS, [line(one, method) for method in methods])}"""


def index() -> str:
    """The page of all days: a line a version and day, newest first; counts over all methods."""
    paths = sorted(FOLDER.glob("*/*.json"), key=newest, reverse=True)
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
    argparse.ArgumentParser(description=__doc__).parse_args()
    day = date.today().isoformat()
    out, folder = BUILD / f"{day}.sqlite", FOLDER / day
    folder.mkdir(parents=True, exist_ok=True)
    BUILD.mkdir(parents=True, exist_ok=True)
    run([], out)
    run([word for version in VERSIONS for word in ("--engine", version)], out)
    subprocess.run(["spincheck", "report", out, "--out", BUILD / day], check=False)
    for one in records(spincheck.results(out), day):
        (folder / f"{name_of(one)}.md").write_text(page(one), encoding="utf-8")
        text = json.dumps(one, ensure_ascii=False, indent=1)
        (folder / f"{name_of(one)}.json").write_text(text + "\n", encoding="utf-8")
    (FOLDER / "index.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main()
