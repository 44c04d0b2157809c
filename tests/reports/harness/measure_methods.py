"""Measures what the steps of every engine and method cost, and writes methods.md.

Of all engines that are installed, or of those named. Verdicts and errors are those of the newest
page of results of the version. What was measured is kept in methods.json, and measured again for
another version of the engine.
"""

import json
import os
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from packaging.requirements import Requirement
from spincheck.engines import Engine, engines
from spincheck.engines.child import ChildEngine
from spincheck.reports.pages.analysis.wording import span
from spincheck.reports.results.verdict_words import RANKS

DOCS = Path(__file__).parents[3] / "docs"
KEPT, PAGE = DOCS / "measured/methods.json", DOCS / "measured/methods.md"
SCENE, WORLDS = "fast-top", "1,64"
#: A process of its own, with its children's; CPU time, since other work on the machine would
#: lengthen wall time. It prints that to the first step, and of a step: the least of five times.
STEPS = f"""
import os, sys, time
from spincheck.engines import engines
from spincheck.scenarios import LIBRARY, load
scenario = load(next(LIBRARY.rglob("{SCENE}.toml")))
engine = engines()[sys.argv[1]]
method, begun = engine.method(sys.argv[2]), sum(os.times()[:4])
session = engine.open(scenario, method, 2.0**-10)
session.advance(1)
session.read_state()
first = sum(os.times()[:4]) - begun
count, times = 64, []
while len(times) < 5:
    begun = time.process_time()
    session.advance(count)
    session.read_state()
    spent = time.process_time() - begun
    if spent < 0.02 and not times:
        count *= 2
    else:
        times.append(spent / count)
session.close()
print(first, min(times))
"""
HEAD = """# Every engine and method

On the scenes of [the newest results](../results/index.md) of the version named: how many verdicts
of each kind; the median error of the attitude at the timestep that users of the engine get who set
none; the timesteps below which errors grow by rounding. *Batch*: whether a world among 64
moves as the same world alone, to the bit or off at the end by so much (`spincheck run {scene}
--worlds {worlds}`; blank: the engine has none, or it was not run). *MB*: the size of what `pip`
installs for it beside spincheck's own parts. *First step*: CPU seconds to it of `{scene}` in a new
process after spincheck has started, which imports MuJoCo and PyBullet, with compiled parts in the
cache. *Step*: CPU time of one, with many in a call where the engine can. What an accuracy costs is
the error against the seconds in any report: `spincheck run {scene} --engine NAME`. `(shipped)`: as
shipped, with what acts by default. Other blanks: not measured, or no longer finite before enough
steps were timed.

Made by `make methods`, with the engines installed that have figures.

"""
COLUMNS = (
    "engine",
    "method",
    "scenes",
    *RANKS,
    "error, °",
    "errors grow below",
    "batch",
    "MB",
    "first step, s",
    "step, µs",
)


def size_of(names: list[str], seen: set[str]) -> float:
    """MB of distributions and of all that they need, but for those that were seen."""
    total = 0.0
    for name in names:
        wanted = Requirement(name)
        if wanted.name.lower() in seen or (wanted.marker and not wanted.marker.evaluate()):
            continue
        seen.add(wanted.name.lower())
        try:
            found = distribution(wanted.name)
        except PackageNotFoundError:
            continue
        files = [Path(str(found.locate_file(file))) for file in found.files or ()]
        total += sum(file.stat().st_size for file in files if file.is_file()) / 1e6
        total += size_of([one for one in found.requires or () if "extra ==" not in one], seen)
    return total


def installed_mb(engine: Engine) -> float | None:
    """MB that an optional engine adds to spincheck and what it always needs."""
    requirements = [Requirement(one) for one in distribution("spincheck").requires or ()]
    own, extra = [], []
    for one in requirements:
        of_extra = one.marker and "extra" in str(one.marker)
        if not of_extra:
            own.append(str(one))
        elif one.marker and one.marker.evaluate({"extra": engine.extra or engine.name}):
            extra.append(str(one).partition(";")[0])
    seen: set[str] = set()
    size_of(own, seen)
    added = size_of(extra, seen)
    return round(added, 0 if added > 10 else 1) if extra else None


def steps(engine: str, method: str) -> dict[str, float]:
    """CPU seconds to the first step, and µs of a step; nothing if it does not come to that."""
    done = subprocess.run(
        [sys.executable, "-c", STEPS, engine, method],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return {}
    first, of_one = map(float, done.stdout.split()[-2:])
    return {"first_step": round(first, 2), "step": float(f"{1e6 * of_one:.2g}")}


def batch(engine: str, method: str) -> str:
    """How a world of a batch moves beside the same world alone."""
    with TemporaryDirectory() as folder:
        words = ["run", SCENE, "--engine", engine, "--method", method, "--worlds", WORLDS, "--json"]
        done = subprocess.run(
            [Path(sys.executable).with_name("spincheck"), *words],
            capture_output=True,
            text=True,
            check=False,
            cwd=folder,
            env=os.environ | {"COLUMNS": "80"},
        )
    try:
        rows = json.loads(done.stdout[done.stdout.index("[\n") :])
    except (ValueError, json.JSONDecodeError):
        return ""
    apart = [
        row[kind] for row in rows for kind in ("alone", "place", "neighbours") if row.get(kind)
    ]
    if any(row["outcome"] != "ok" for row in rows):
        return next(row["reason"] or row["outcome"] for row in rows if row["outcome"] != "ok")
    return "bits" if not apart else words_of(max(apart, key=lambda one: one.get("degrees") or 0.0))


def words_of(apart: dict[str, Any]) -> str:
    """A difference in ulp and degrees."""
    return f"{apart['ulp']:.2g} ulp, {apart['degrees']:.1g}°"


def measured(kept: dict[str, Any], names: list[str]) -> None:
    """Measure what is missing, and write it after each method."""
    for engine in engines().values():
        if engine.of_file or (names and engine.name not in names):
            continue
        old = kept.get(engine.name, {})
        if old.get("version") != engine.version:
            old = kept[engine.name] = {"version": engine.version, "methods": {}}
            old["mb"] = installed_mb(engine)
        for method in engine.methods:
            if method.name in old["methods"]:
                continue
            # Of a process that the engine runs in, under node, the time is not known.
            is_child = isinstance(engine, ChildEngine)
            one: dict[str, Any] = {} if is_child else steps(engine.name, method.name)
            if engine.has_batches and not method.as_shipped:
                one["batch"] = batch(engine.name, method.name)
            old["methods"][method.name] = one | {"as_shipped": method.as_shipped}
            KEPT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            print(engine.name, method.name, one, flush=True)


def newest(engine: str, version: str) -> dict[str, Any]:
    """The newest results of a version; empty if there are none."""
    found = [
        json.loads(path.read_text(encoding="utf-8"))
        for path in sorted((DOCS / "results").glob(f"*/{engine}-*.json"))
    ]
    ours = [one for one in found if (one["engine"], one["version"]) == (engine, version)]
    return ours[-1] if ours else {"verdicts": []}


def lines(kept: dict[str, Any]) -> list[list[str]]:
    """The lines of the table, engines by name, methods as their adapters list them."""
    made = []
    for name, one in sorted(kept.items()):
        results = newest(name, one["version"])
        for method, known in one["methods"].items():
            words = [word for of, _, word, _ in results["verdicts"] if of == method]
            floors = [
                timestep
                for run, timestep in results.get("errors_grow_below", {}).items()
                if run.split()[0] == method
            ]
            off = [
                degrees
                for run, degrees in results.get("degrees_off", {}).items()
                if run.split()[0] == method and degrees is not None
            ]
            made.append(
                [
                    f"{name} {one['version']}",
                    f"{method} (shipped)" if known["as_shipped"] else method,
                    str(len(words) or ""),
                    *(str(words.count(word) or "") for word in RANKS),
                    f"{median(off):.2g}" if off else "",
                    span(floors) if floors else "",
                    known.get("batch", ""),
                    "" if one["mb"] is None else f"{one['mb']:g}",
                    *(
                        f"{known[what]:g}" if what in known else ""
                        for what in ("first_step", "step")
                    ),
                ]
            )
    return made


def page(kept: dict[str, Any]) -> str:
    """The page in Markdown."""
    rows = [COLUMNS, ["---"] * len(COLUMNS), *lines(kept)]
    return HEAD.format(scene=SCENE, worlds=WORLDS) + "".join(
        f"| {' | '.join(cells)} |\n" for cells in rows
    )


def main() -> None:
    """Measure, and write the page."""
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    measured(kept, sys.argv[1:])
    PAGE.write_text(page(kept), encoding="utf-8")


if __name__ == "__main__":
    main()
