"""Runs the library and writes dated pages of every engine's version: `make results`.

A page and a JSON file a version go to docs/results/DATE, the report with a page a scene to
build/results/DATE. Of a version's pages of other days those stay that have a verdict which the
newest has not. All runs are kept in build/results/spincheck.sqlite: after a stop the next call goes
on with them.
"""

import argparse
import json
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from statistics import median
from typing import Any

from spincheck.engines import engines
from spincheck.reports.cli.run.summary import verdict_records
from spincheck.reports.pages.analysis import wording
from spincheck.reports.results.store import open_store
from spincheck.reports.results.verdict_words import RANKS
from spincheck.scenarios import LIBRARY

FOLDER = Path(__file__).parent
BUILD = FOLDER.parents[1] / "build" / "results"
FAULTS = FOLDER.parent / "measured/known-issues.toml"
#: Older versions, with the method that is run beside their defaults, and the scenes of both.
VERSIONS = {
    "mujoco@3.3.7": "RK4",
    "mujoco@3.6.0": "RK4",
    "mujoco@3.10.0": "RK4",
    "pybullet@3.2.6": "multibody",
}
TOPS = (LIBRARY / "free", LIBRARY / "heavy")
COLUMNS = ("method", "scenes", *RANKS, "errors grow below", "median error", "largest error", "on")
HEAD = """# Results by date and version

Each page shows what one version of an engine did: its known issues with what to do about them, the
verdicts and errors of each method, and each scene. The engines that are installed with spincheck
are run on the whole library; optional engines on the whole library, too, and
older versions on the free and the heavy tops, both with the fewer timesteps of `spincheck run
--quick`; where fewer scenes or methods are listed, the others were not run yet.

*Error* is that of the attitude at the timestep that users of the engine get who set none. The
method `default` is the engine as shipped; in the others everything that a scene does not call for
is switched off. *Errors grow below* that timestep, by rounding.
[How to object to a result](../project/neutrality.md).

`make results` makes these pages, and in `build/results` a report with a page for each scene.
"""

NO_FAULTS = "None is listed: not every engine was searched for them.\n"

Record = dict[str, Any]


def command(*words: object) -> int:
    """Call spincheck, and return its exit code: 1, something disagrees, is a result like others."""
    here = Path(sys.executable).with_name("spincheck")
    code = subprocess.run([here, *map(str, words)], check=False).returncode
    if code not in (0, 1, 3):
        raise SystemExit(f"'spincheck {words[0]}' ended with exit code {code}")
    return code


def runs() -> Iterator[tuple[list[str], tuple[object, ...]]]:
    """Engines, and how `spincheck run` is called for them: the whole library comes last."""
    every = [one for one in engines().values() if not one.of_file]
    for one in every:
        if one.is_optional:
            yield [one.name], (LIBRARY, "--quick", "--engine", one.name)
    for name, method in VERSIONS.items():
        methods = ("--method", "default", "--method", method)
        yield [name], (*TOPS, *methods, "--quick", "--engine", name)
    yield [one.name for one in every if not one.is_optional], (LIBRARY,)


def records(stored: Any, names: list[str], day: str) -> list[Record]:
    """What each version of the engines named did, as its JSON file has it."""
    versions = {
        (row.key.engine, row.engine_version) for row in stored.rows if row.key.engine in names
    }
    return [record(stored, *names, day) for names in sorted(versions)]


def record(stored: Any, engine: str, version: str, day: str) -> Record:
    """What one version did; an engine at an older version is named `engine@version` in results."""
    verdicts = [one for one in stored.verdicts if one.key.engine == engine]
    # Methods are run at 1 ms, too; an engine's own timestep is no shorter, and comes last.
    rows = sorted(
        (
            one
            for one in stored.rows
            if one.key.engine == engine and one.stock and one.outcome in ("ok", "diverged")
        ),
        key=lambda one: one.timestep,
    )
    return {
        "engine": engine.partition("@")[0],
        "version": version,
        "date": day,
        "verdicts": sorted(
            [one.key.method, one.key.scenario, one.verdict, reason(one)] for one in verdicts
        ),
        "degrees_off": {
            f"{one.key.method} {one.key.scenario}": float(
                f"{math.degrees(one.errors['attitude']):.3g}"
            )
            if one.errors
            else None
            for one in rows
        },
        "errors_grow_below": {
            f"{one['method']} {one['scenario']}": float(f"{finest:.3g}")
            for one in verdict_records(stored)
            if one["engine"] == engine and (finest := one["finest_useful_timestep"])
        },
    }


def reason(verdict: Any) -> str:
    """Why, without the list of what is active in an engine as shipped: the same for all scenes."""
    text: str = verdict.reason.partition("; active though the scene does not call for it")[0]
    return text


def scenes(one: Record) -> list[str]:
    """The scenes that a version was run on."""
    return sorted({scene for _, scene, _, _ in one["verdicts"]})


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
    floors = [
        timestep
        for key, timestep in one.get("errors_grow_below", {}).items()
        if key.split()[0] == method
    ]
    grow = wording.span(floors) if floors else ""
    return [method, str(len(words)), *counts, grow, *(cells or ["–", "–"]), worst_on]


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
    return [int(number) for number in re.findall(r"\d+", version.split()[0])]


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
    run_of = f"{fault['method']} {fault['scene']}"
    if run_of not in one["degrees_off"]:
        return shown
    off = degrees(one["degrees_off"][run_of])
    return f"{shown}; here `{fault['method']}` on {fault['scene']}: {off}"


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


def as_json(one: Record) -> str:
    """The file of a version, a line a verdict."""
    verdicts = ",\n".join(json.dumps(verdict, ensure_ascii=False) for verdict in one["verdicts"])
    text = json.dumps(one | {"verdicts": []}, ensure_ascii=False)
    return text.replace('"verdicts": []', f'"verdicts": [\n{verdicts}\n]', 1) + "\n"


def page(one: Record) -> str:
    """The page of a version."""
    methods = sorted({name for name, *_ in one["verdicts"]})
    return f"""# {one["engine"]} {one["version"]}, {one["date"]}

## Known issues

{"".join(faults(one)) or NO_FAULTS}
## On {len(scenes(one))} scenes

{table(COLUMNS, [line(one, method) for method in methods])}
## Each scene

The error, with the verdict where it is not `converges`.
[Every verdict with its reason]({name_of(one)}.json).

{table(("scene", *methods), scene_lines(one, methods))}"""


def scene_lines(one: Record, methods: list[str]) -> list[list[str]]:
    """What each method did on each scene, a line a scene."""
    words = {(method, scene): word for method, scene, word, _ in one["verdicts"]}
    return [
        [scene, *(cell(one, method, scene, words.get((method, scene), "")) for method in methods)]
        for scene in scenes(one)
    ]


def cell(one: Record, method: str, scene: str, word: str) -> str:
    """The error of a method on a scene, and its verdict."""
    run_of = f"{method} {scene}"
    shown = degrees(one["degrees_off"][run_of]) if run_of in one["degrees_off"] else ""
    return ", ".join(part for part in (shown, "" if word == "converges" else word) if part)


def index() -> str:
    """The page of all days: a line a version and day, newest first; counts over all methods."""
    paths = sorted(FOLDER.glob("*/*.json"), key=newest, reverse=True)
    lines = []
    for path in paths:
        one = json.loads(path.read_text(encoding="utf-8"))
        words = [word for _, _, word, _ in one["verdicts"]]
        link = f"[{one['engine']} {one['version']}]({path.parent.name}/{path.stem}.md)"
        counts = [str(words.count(word) or "") for word in RANKS]
        lines.append([one["date"], link, str(len(scenes(one))), *counts])
    columns = ("date", "engine", "scenes", *RANKS)
    pages = "\n".join(path.relative_to(FOLDER).with_suffix("").as_posix() for path in paths)
    return f"{HEAD}\n{table(columns, lines)}\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"


def judged(one: Record) -> set[tuple[str, str]]:
    """The method and scene of each verdict."""
    return {(method, scene) for method, scene, *_ in one["verdicts"]}


def superseded(one: Record) -> list[Path]:
    """The files of the same version of earlier days whose verdicts it all has anew."""
    return [
        path
        for path in sorted(FOLDER.glob(f"*/{name_of(one)}.json"))
        if path.parent.name < one["date"]
        and judged(json.loads(path.read_text(encoding="utf-8"))) <= judged(one)
    ]


def publish(stored: Any, names: list[str], day: str) -> None:
    """Write the pages of the engines named, and the page of all days."""
    folder = FOLDER / day
    folder.mkdir(exist_ok=True)
    for one in records(stored, names, day):
        (folder / f"{name_of(one)}.md").write_text(page(one), encoding="utf-8")
        (folder / f"{name_of(one)}.json").write_text(as_json(one), encoding="utf-8")
        for path in superseded(one):
            path.unlink()
            path.with_suffix(".md").unlink()
    (FOLDER / "index.md").write_text(index(), encoding="utf-8")


def main() -> None:
    """Run what is missing in the result file; an engine's pages are written when it has run."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    out = BUILD / "spincheck.sqlite"
    day = date.today().isoformat()
    for names, words in runs():
        if command("run", *words, "--out", out) == 3:
            print(f"{' and '.join(names)} could not be run, and gets no page.")
        else:
            with open_store(out) as store:
                publish(store.read(), names, day)
    command("report", out, "--out", BUILD / day)


if __name__ == "__main__":
    main()
