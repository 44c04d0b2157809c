"""Versions of engines: which are installed, and what changed from one to the next."""

from dataclasses import asdict
from typing import Annotated

import typer

from .options import AsJson
from .terminal import AGREES, BAD_INPUT, DISAGREES, NOT_RUN, Complaint, say, table, to_json

app = typer.Typer()


def list_installed(remove: list[str], as_json: bool) -> None:
    """Remove versions, then list those that are there.

    Raises
    ------
    Complaint
        If one to remove is not there.
    """
    from ...engines.versions import VersionError, installed
    from ...engines.versions import remove as remove_version

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
    timestep: Annotated[float, typer.Option(min=1e-9, help="s, of every run.")] = 1e-3,
    as_json: AsJson = False,
) -> None:
    """Say what changed from version to version of an engine: motion, errors, outcomes, speed.

    Example: spincheck versions mujoco 3.1.6 3.6.0 3.10.0 4.0.0 tennis-racket fast-top

    Each version is installed once, into a folder of its own. Exits with 1 if a newer one is worse.
    """
    from ...engines.versions import VersionError, versioned
    from ..harness.executors import LocalWorkers
    from ..harness.version_changes import SCENES, version_changes
    from .named_scenes import scenes_to_run

    numbers = [word for word in arguments if word[:1].isdigit()]
    if len(numbers) < 2:
        raise Complaint("'versions' takes two versions at the least, oldest first", BAD_INPUT)
    scenes = scenes_to_run([word for word in arguments if word not in numbers] or list(SCENES))
    try:
        chosen = [versioned(f"{engine}@{number}") for number in numbers]
    except VersionError as error:
        raise Complaint(str(error), NOT_RUN) from None
    changes = []
    with LocalWorkers(1) as executor:
        for change in version_changes(chosen, scenes, timestep, executor):
            changes.append(change)
            if not as_json and change.words:
                print(change.words, flush=True)
    worse = sum(change.is_worse for change in changes)
    if as_json:
        print(to_json({"changes": [asdict(change) for change in changes], "worse": worse}))
    else:
        same = sum(not change.words for change in changes)
        say(f"{same} of {len(changes)} comparisons are alike; in {worse} the newer one is worse.")
    raise typer.Exit(DISAGREES if worse else AGREES)
