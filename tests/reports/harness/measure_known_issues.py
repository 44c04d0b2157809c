"""Runs the command of every known issue, and writes docs/measured/known-issues.md.

Or of those alone whose names are given, such as google/brax#48: others stay as the page has them.
"""

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

from known_issues import DATA, KnownIssue, known_issues

PAGE = DATA.with_suffix(".md")
#: s that a command may take.
LIMIT = 900
#: Lines of a measurement that are shown.
SHOWN = 8
NOT_RUN, MISSED = "not run", "**not as expected**"
HEAD = """# Known issues

Public issues on the rotation of single rigid bodies: what each is about, a command of spincheck
that shows it, and the verdict that this gave. *Stand-in*: another engine than the issue's was run,
on a scene with the same difficulty. `MODEL` stands for a model in `known-issues.toml`.

`make known-issues` runs the commands in that file and writes this page. Of {issues} issues {asked}
have a command; {run} were run, and {met} ended as in an earlier run, which the file holds.
`--quick` means fewer timesteps, which leave more `unresolved`.
"""


def measured(issue: KnownIssue) -> list[str]:
    """What came of an issue's command, line by line."""
    with TemporaryDirectory() as folder:
        words = issue.words(Path(folder))
        if words[0] == "run":
            words += ["--out", str(Path(folder, "results.sqlite")), "--jobs", "1"]
        if words[0] in OF_RECORDS:
            words.append("--json")
        program = str(Path(sys.executable).with_name("spincheck"))
        try:
            done = subprocess.run(
                [program, *words], capture_output=True, text=True, timeout=LIMIT, check=False
            )
        except subprocess.TimeoutExpired:
            return [f"not ended after {LIMIT} s"]
    if words[0] not in OF_RECORDS:
        return ["the exact motion" if done.returncode == 0 else done.stderr.strip()]
    try:
        record = json.loads(done.stdout)
    except json.JSONDecodeError:
        return [done.stderr.strip().splitlines()[-1] if done.stderr else "no answer"]
    return list(OF_RECORDS[words[0]](record))


def _of_gradients(record: list[dict]) -> Iterator[str]:
    for row in record:
        method = f"{row['engine']} {row['method']}, {row['derivative']}"
        yield f"{method}: {row['judged']['verdict']}"


def _of_runs(record: dict) -> Iterator[str]:
    versions = {row["engine"]: row["engine_version"] for row in record["rows"]}

    def who(one: dict) -> str:
        engine, _, encoding = one["engine"].partition(" as ")
        version = versions.get(one["engine"], "")
        described = f", {encoding}" if encoding else ""
        return f"{engine.partition('@')[0]} {version} {one['method']}{described}"

    for verdict in record["verdicts"]:
        if verdict["verdict"] != "unsupported":
            yield f"{who(verdict)}: {verdict['verdict']}"


def _of_model(record: dict) -> Iterator[str]:
    versions = {
        f"{held['engine']} {held['configuration']}": held["engine_version"]
        for link in record["links"]
        for held in link["held"]
    }
    for who, count in record["summary"]["held_wrongly"].items():
        engine, configuration = who.split()
        name = f"{engine.partition('@')[0]} {versions[who]} {configuration}"
        added = record["summary"]["mass"]["added"].get(who, 0.0)
        yield f"{name}: {count} of its links held wrongly" + (f", {added:g} kg added" * bool(added))


#: What the JSON of each command is read by.
OF_RECORDS = {"run": _of_runs, "inspect": _of_model, "gradients": _of_gradients}


def meets(issue: KnownIssue, lines: list[str]) -> bool:
    """Whether a measurement contains all that is expected, with an engine's version or without."""
    there = {*lines, *map(_without_version, lines)}
    return there.issuperset(issue.expected)


def _without_version(line: str) -> str:
    engine, _, rest = line.split(" ", 2) if line.count(" ") > 1 else (line, "", "")
    return f"{engine} {rest}".strip()


def page(answers: dict[KnownIssue, list[str]]) -> str:
    """The page, by engine; of issues that were not run now, what it had."""
    issues = known_issues()
    asked = [issue for issue in issues if issue.command]
    items = {one: _item(one, answers[one]) if one in answers else _kept(one) for one in asked}
    run = [item for item in items.values() if not item.endswith(f": {NOT_RUN}.")]
    met = sum(MISSED not in item for item in run)
    counts = {"issues": len(issues), "asked": len(asked), "run": len(run), "met": met}
    parts = [HEAD.format(**counts).rstrip("\n")]
    engines = sorted({issue.engine for issue in asked}, key=lambda name: (not name, name))
    for engine in engines:
        parts += [f"\n## {engine or 'The exact motion alone'}\n"]
        parts += [items[one] for one in asked if one.engine == engine]
    parts += ["\n## Without a command\n"]
    parts += [f"- **{i.title}** ([{i.name}]({i.url})). {i.why}" for i in issues if not i.command]
    return "\n".join(parts) + "\n"


def _kept(issue: KnownIssue) -> str:
    """The item that the page has of an issue, if it is of the same command."""
    fresh = _item(issue, None).removesuffix(f"{NOT_RUN}.")
    _, found, rest = PAGE.read_text(encoding="utf-8").partition(fresh)
    return fresh + (rest.partition("\n")[0] if found else f"{NOT_RUN}.")


def _item(issue: KnownIssue, lines: list[str] | None) -> str:
    shown = [NOT_RUN] if lines is None else lines[:SHOWN]
    if lines is not None and not meets(issue, lines):
        shown = [MISSED, *shown]
    if lines is not None and len(lines) > SHOWN:
        shown = [*shown, f"and {len(lines) - SHOWN} more"]
    where = f"[{issue.name}]({issue.url}){', stand-in' * issue.stand_in}"
    answer = "; ".join(shown)
    return f"- **{issue.title}** ({where}).\n  `spincheck {issue.command}`: {answer}."


def main(names: Sequence[str]) -> int:
    """Write the page; 1 if something is not as expected."""
    named = [issue for issue in known_issues() if issue.name in names or not names]
    asked = [issue for issue in named if issue.command]
    answers: dict[KnownIssue, list[str]] = {}
    with ThreadPoolExecutor(2) as threads:
        for issue, lines in zip(asked, threads.map(measured, asked), strict=True):
            answers[issue] = lines
            print(json.dumps([issue.url, lines], ensure_ascii=False), flush=True)
    PAGE.write_text(page(answers), encoding="utf-8")
    return int(not all(meets(issue, lines) for issue, lines in answers.items()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
