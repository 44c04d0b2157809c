"""Versions of engines: which are installed, and what changed from one to the next."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import REPORT_FOLDER, AsJson, Python
from ..terminal import AGREES, BAD_INPUT, DISAGREES, NOT_RUN, Complaint, say, table, to_json

if TYPE_CHECKING:
    from ...harness.version_changes import VersionChange

app = typer.Typer()


def list_installed(remove: list[str], as_json: bool) -> None:
    """Remove versions, then list those that are there.

    Raises
    ------
    Complaint
        If a version to remove is not installed.
    """
    from ....engines.versions import VersionError, installed
    from ....engines.versions import remove as remove_version

    for name in remove:
        try:
            say(f"Removed {remove_version(name)}")
        except VersionError as error:
            raise Complaint(f"'--remove': {error}", BAD_INPUT) from None
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
    timestep: Annotated[
        float, typer.Option(min=1e-9, help="s, of the runs that are compared.")
    ] = 1e-3,
    python: Python = "",
    out: Annotated[Path, typer.Option(help="The folder of the page.")] = REPORT_FOLDER,
    as_json: AsJson = False,
) -> None:
    """Compare versions of an engine: motions, errors, verdicts, speed.

    Example: spincheck versions mujoco 3.1.6 3.6.0 3.10.0 4.0.0 tennis-racket fast-top

    Each version is installed once, into a folder of its own. Writes OUT/ENGINE-versions.html.

    Exits with 1 if a newer one is worse: a run no longer ends well, a verdict falls, an error or
    the time of a step grows by a fifth.
    """
    from ....engines.versions import VersionError, versioned
    from ...harness.executors import LocalWorkers
    from ...harness.version_changes import SCENES, over_versions
    from ...pages.versions.version_page import write_version_page
    from ..named_scenes import scenes_to_run

    numbers = [word for word in arguments if word[:1].isdigit()]
    if len(numbers) < 2:
        raise Complaint("'versions' takes two versions at the least, oldest first", BAD_INPUT)
    scenes = scenes_to_run([word for word in arguments if word not in numbers] or list(SCENES))
    try:
        chosen = [versioned(f"{engine}@{number}", python) for number in numbers]
    except VersionError as error:
        raise Complaint(str(error), BAD_INPUT if error.is_usage else NOT_RUN) from None
    over = []
    with LocalWorkers(1) as executor:
        for one in over_versions(chosen, scenes, timestep, executor):
            over.append(one)
            if not as_json:
                _print_changes(one.changes)
    try:
        page = write_version_page(engine, over, timestep, out)
    except OSError as error:
        raise Complaint(f"'--out': {out} cannot be written: {error.strerror}", BAD_INPUT) from None
    changes = [change for one in over for change in one.changes]
    worse = sum(change.is_worse for change in changes)
    if as_json:
        records = [asdict(c) | {"words": str(c) if c.what else ""} for c in changes]
        document = {"changes": records, "worse": worse, "page": str(page)}
        print(to_json(document))
    else:
        same = sum(not change.what for change in changes)
        say(f"{same} of {len(changes)} comparisons are alike; in {worse} the newer one is worse.")
        print(page)
    raise typer.Exit(DISAGREES if worse else AGREES)


def _print_changes(changes: "list[VersionChange]") -> None:
    for change in changes:
        if change.what:
            print(change, flush=True)
