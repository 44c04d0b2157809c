"""Versions of engines: which are installed, and what changed from one to the next."""

from pathlib import Path
from typing import Annotated

import typer

from ..options import CORES, RESULT_FILE, AsEncoded, AsJson, Jobs, Methods, Python
from ..terminal import BAD_INPUT, Complaint, as_complaint, say, table, to_json

app = typer.Typer()


def list_installed(remove: list[str], as_json: bool) -> None:
    """Remove versions, then list those that are there."""
    from ....engines.versions import VersionError, installed
    from ....engines.versions import remove as remove_version

    for name in remove:
        with as_complaint(VersionError, before="'--remove': "):
            say(f"Removed {remove_version(name)}")
    rows = [
        {"engine": one.name, "MB": round(one.megabytes), "folder": str(one.folder)}
        for one in installed()
    ]
    if as_json:
        print(to_json({"installed": rows}))
    elif rows:
        table(rows)
    else:
        say("No version is installed; 'spincheck run --engine mujoco@3.1.6' installs one.")


@app.command(epilog="Example: spincheck versions mujoco 3.3.0 4.0.0 fast-top")
def versions(
    engine: Annotated[str, typer.Argument(metavar="ENGINE", help="Such as mujoco.")],
    arguments: Annotated[
        list[str],
        typer.Argument(metavar="V1 V2... [SCENARIO]...", help="Versions, oldest first; scenes."),
    ],
    method: Methods = None,
    jobs: Jobs = CORES,
    out: Annotated[Path, typer.Option(help="The result file; added to.")] = RESULT_FILE,
    as_encoded: AsEncoded = "",
    python: Python = "",
    as_json: AsJson = False,
) -> None:
    """Compare versions of an engine: verdicts, outcomes, errors, cost.

    Example: spincheck versions mujoco 3.1.6 3.6.0 3.10.0 4.0.0 tennis-racket fast-top

    Each version is installed once, into a folder of its own, and run as 'spincheck run --engine
    ENGINE@VERSION' does; neighbours are compared as 'spincheck compare' compares result files.

    Exits with 1 if anything got worse from one version to the next.
    """
    from ..choosing import Where
    from ..results.compare import (
        SCENES,
        changes_as_json,
        changes_between_versions,
        exit_code,
        print_changes,
    )
    from ..run import running
    from ..run.encodings import encoding_changes, encoding_lines, named_encodings

    numbers = [word for word in arguments if word[:1].isdigit()]
    if len(numbers) < 2:
        raise Complaint("'versions' takes two versions at the least, oldest first", BAD_INPUT)
    scenes = [word for word in arguments if word not in numbers] or list(SCENES)
    names = [f"{engine}@{number}" for number in numbers]
    encodings = named_encodings(as_encoded)
    results = running.run(
        *(scenes, names, method or [], [], Where(jobs), out), python=python, encodings=encodings
    )
    changed = changes_between_versions(results, names)
    if as_json:
        print(to_json(changes_as_json(changed)))
    else:
        print_changes(changed)
        if encodings:
            for line in (
                *encoding_lines(results.encodings),
                *encoding_changes(results.encodings, names),
            ):
                print(line)
        say(f"Results are in {out}; 'spincheck report {out}' shows the versions side by side.")
    raise typer.Exit(exit_code(changed))
