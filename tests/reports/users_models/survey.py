"""Inspects the models of public packages and writes the tables of docs/measured/public-models.md.

Run by ``make survey``, which installs the packages; PyBullet comes with its own.
"""

import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import partial
from importlib.metadata import distribution
from itertools import chain
from pathlib import Path

import psutil
from spincheck.engines.users_models import AGREES, ModelFileError, read_model
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.users_models.inspection import (
    READ_LIMIT,
    Inspection,
    LinkReading,
    ReaderEngine,
    inspect_model,
    reader_engines,
)
from spincheck.reports.users_models.mend import Wishes, mended

#: Distributions, and which of their files are models.
PACKAGES = {
    "pybullet": re.compile(r"pybullet_data/(?!random_urdfs/).*\.(urdf|xml)$"),
    "example-robot-data": re.compile(r".*\.urdf$"),
    "icub-models": re.compile(r".*\.urdf$"),
    "dm_control": re.compile(r"dm_control/(suite|locomotion|entities|third_party)/.*\.xml$"),
}
#: Files that are parts of others, or no models at all.
PARTS = ("has no <body>", "has no <link>", "is neither URDF")
DOCUMENT = Path("docs/measured/public-models.md")
BEGIN, END = "<!-- make survey writes from here -->", "<!-- to here -->"
#: How far off a tensor is, relative to the file's.
LIMITS = (1e-12, AGREES, 1e-2)
TEN_TIMES = 10.0
#: Kinds of difference in words, in the table's order.
CAUSES = {
    "made up": "made up from collision shapes",
    "no tensor": "made up where the file states a mass alone",
    "zero": "set to zero",
    "nothing stated": "body where the file states none",
    "rotation lost": "rotation of the inertial frame lost",
    "turned": "axes turned",
    "sum": "fused parts summed wrongly",
    "products dropped": "products of inertia dropped",
    "other": "another tensor, mass or com",
}
#: How models are mended, by the options of `inspect`, and how many are then held; see `is_held`.
WISHES = {
    "--mend": Wishes(),
    "--mend --nearest": Wishes(nearest=True),
    "--mend --nearest --made-up": Wishes(nearest=True, made_up=True),
}
HELD: Counter[str] = Counter()
#: The last two are from before two faults of MuJoCo's URDF reader were mended.
ENGINES = ("mujoco", "pybullet", "mujoco@3.3.7", "mujoco@3.13.0")
JOBS = 2


def models(package: str) -> Iterator[tuple[Path, tuple[tuple[str, Path], ...]]]:
    """Files of a package, and the folder that its meshes are inside of."""
    wanted = PACKAGES[package]
    for file in sorted(distribution(package).files or [], key=str):
        if wanted.match(str(file)):
            path = Path(str(file.locate())).resolve()
            top = [folder for folder in path.parents if folder.name == "pybullet_data"]
            yield path, (("pybullet_data", top[0]),) if top else ()


def inspected(
    executor, engines: list[ReaderEngine], path, packages
) -> tuple[Inspection, dict[str, bool]] | str:
    """An inspection, and whether engines hold the model, by `WISHES`; or why it is not read."""
    try:
        model = read_model(path, packages)
        newest = [engine for engine in engines if not engine.site]
        one = inspect_model(model, executor, engines if model.format == "urdf" else newest)
    except ModelFileError as error:
        return f"{path.name}{str(error).removeprefix(str(path))}"
    held = {"as they are": is_held(one)}
    for name, wishes in WISHES.items():
        copy = path.with_name(f"{name.strip('-')}-{path.name}")
        copy.write_bytes(mended(one, wishes).data)
        try:
            held[name] = is_held(inspect_model(read_model(copy, packages), executor, newest))
        finally:
            copy.unlink()
    return one, held


def is_held(inspection: Inspection) -> bool:
    """Whether every newest engine holds every link, but for what PyBullet does without its flag."""
    readings = [held for link in inspection.links for held in link.readings]
    asked = [h for h in readings if "@" not in h.engine and h.column != ("pybullet", "default")]
    return not any(held.agrees is False or held.kind == "refused" for held in asked)


def survey() -> tuple[dict[str, list[Inspection]], dict[str, list[str]]]:
    """Every package's inspections, and its files that are refused."""
    inspections_of: dict[str, list[Inspection]] = {}
    refused: dict[str, list[str]] = {}
    engines = reader_engines(ENGINES)
    with LocalWorkers(JOBS, READ_LIMIT) as executor:
        for package in PACKAGES:
            tasks = [partial(inspected, executor, engines, *model) for model in models(package)]
            results = list(executor.each(tasks))
            done = [one for one in results if not isinstance(one, str)]
            inspections_of[package] = [inspection for inspection, _ in done]
            for _, held in done:
                HELD.update(held)
            words = [one for one in results if isinstance(one, str)]
            refused[package] = sorted(w for w in words if not any(part in w for part in PARTS))
            print(f"{package}: {len(inspections_of[package])} models", file=sys.stderr)
    return inspections_of, refused


def table(heads: list[str], rows: list[list[object]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)


def stated_table(inspections_of: dict[str, list[Inspection]], refused: dict[str, list[str]]) -> str:
    rows = []
    for package, inspections in inspections_of.items():
        links = [link for one in inspections for link in one.links]
        kinds = Counter(p.kind for link in links for p in link.problems)
        bad = [i for i in inspections if any(p.impossible for li in i.links for p in li.problems)]
        rows.append(
            [
                f"`{package}` {distribution(package).version}",
                len(inspections),
                len(refused[package]),
                len(links),
                sum(link.link.has_inertia for link in links),
                len(bad),
                kinds["not positive definite"] + kinds["triangle inequality"],
                kinds["zero tensor"] + kinds["zero mass"],
                kinds["placeholder"],
                kinds["radius of gyration"],
            ]
        )
    totals = [sum(row[column] for row in rows) for column in range(1, len(rows[0]))]
    heads = [
        "package",
        "models",
        "refused",
        "links",
        "with an inertia",
        "models with an impossible one",
        "tensors that no body has",
        "zero mass or tensor",
        "placeholders",
        "spread beyond the shapes",
    ]
    return table(heads, [*rows, ["all", *totals]])


HELD_HEADS = [
    "engine",
    "models refused",
    "links compared",
    "of them fused",
    *(f"off by more than {limit:g}" for limit in LIMITS),
    f"{TEN_TIMES:g} times too large or too small",
    "axes turned, moments kept",
    "fused and off",
]


def held_rows(inspections_of: dict[str, list[Inspection]], form: str) -> list[list[object]]:
    """One row a configuration."""
    by_column: dict[tuple[str, str, str], list[LinkReading]] = {}
    refusals: Counter[tuple[str, str, str]] = Counter()
    for one in chain(*inspections_of.values()):
        if one.model.format != form:
            continue
        for link in one.links:
            for held in link.readings:
                by_column.setdefault(_column(held), []).append(held)
        for held in one.links[0].readings:
            refusals[_column(held)] += (held.engine, held.configuration) in one.refusals
    return [
        [" ".join([engine.partition("@")[0], *rest]), refusals[engine, *rest], *_counted(held)]
        for (engine, *rest), held in by_column.items()
    ]


def _column(held: LinkReading) -> tuple[str, str, str]:
    return held.engine, held.engine_version, held.configuration


def _counted(held: list[LinkReading]) -> list[int]:
    compared = [h for h in held if h.difference is not None and h.expected.is_physical]
    unlike = [sum(h.difference.worst > limit for h in compared) for limit in LIMITS]
    return [
        len(compared),
        sum(bool(h.fused) for h in compared),
        *unlike,
        sum(_is_far(h) for h in compared),
        sum("axes turned" in h.cause and "moments kept" in h.cause for h in compared),
        sum(bool(h.fused) and h.agrees is False for h in compared),
    ]


def _is_far(held: LinkReading) -> bool:
    stated, held_trace = held.expected.inertia_com.trace(), held.body.inertia_com.trace()
    return bool(held_trace * TEN_TIMES <= stated or held_trace >= TEN_TIMES * stated)


def cause_table(inspections_of: dict[str, list[Inspection]]) -> str:
    counts: dict[str, Counter[str]] = {}
    for one in chain(*inspections_of.values()):
        for link in one.links:
            for held in link.readings:
                column = f"{held.engine} {held.configuration}"
                if held.agrees is False:
                    counts.setdefault(held.kind, Counter())[column] += 1
    columns = sorted({column for counter in counts.values() for column in counter})
    rows = [
        [words, *(counts[kind][column] for column in columns)]
        for kind, words in CAUSES.items()
        if kind in counts
    ]
    return table(["links held otherwise", *columns], rows)


def heavy_table(inspections_of: dict[str, list[Inspection]]) -> str:
    """What the links of a robot weigh together, where engines add most."""
    rows = []
    for one in chain(*inspections_of.values()):
        stated = sum(li.link.stated.mass for li in one.links if li.link.stated is not None)
        by_engine: Counter[str] = Counter()
        for link in one.links:
            for held in link.readings:
                if held.body is not None and held.engine == "pybullet":
                    by_engine[held.configuration] += held.body.mass
        gained = by_engine["default"] - stated
        rows.append((gained, one.model.path, stated, by_engine["default"]))
    rows.sort(key=lambda row: row[0], reverse=True)
    return table(
        ["model", "kg in the file", "kg in PyBullet"],
        [
            ["/".join(path.parts[-2:]), f"{kg:.4g}", f"{held_kg:.4g}"]
            for _, path, kg, held_kg in rows[:5]
        ],
    )


def written(
    inspections_of: dict[str, list[Inspection]], refused: dict[str, list[str]], seconds: float
) -> str:
    files = "\n".join(f"- `{line}`" for lines in refused.values() for line in lines)
    return "\n\n".join(
        [
            BEGIN,
            stated_table(inspections_of, refused),
            "What engines hold of the URDF files' links that have an inertia:",
            table(HELD_HEADS, held_rows(inspections_of, "urdf")),
            "Of the MJCF files':",
            table(HELD_HEADS, held_rows(inspections_of, "mjcf")),
            "By cause, all links:",
            cause_table(inspections_of),
            "Models of which every engine holds every link, PyBullet without its flag aside, as "
            "they are and as `inspect` mends them:",
            table(["models", "held"], [list(pair) for pair in HELD.items()]),
            "The robots that gain most by links that state nothing:",
            heavy_table(inspections_of),
            "Refused, because engines or parsers do not read them alike:",
            files,
            f"Made in {seconds:.0f} s of CPU time.",
            END,
        ]
    )


def main() -> None:
    """Write the tables."""
    inspections_of, refused = survey()
    used = psutil.Process().cpu_times()
    seconds = used.user + used.system + used.children_user + used.children_system
    text = DOCUMENT.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    tables = written(inspections_of, refused, seconds)
    DOCUMENT.write_text(before + tables + after, encoding="utf-8")
    print(f"{DOCUMENT} has the tables", file=sys.stderr)


if __name__ == "__main__":
    main()
