"""Arguments and options that commands of the command line share."""

import os
from pathlib import Path
from typing import Annotated

import typer

RESULT_FILE = Path("spincheck.sqlite")
REPORT_FOLDER = Path("spincheck-report")
#: Number of members of an ensemble if the option has no number.
MEMBERS = 200
CORES = os.cpu_count() or 1


def _seconds(text: str) -> float:
    """Return the number of seconds in a text; raise `typer.BadParameter` if it is no number."""
    try:
        return float(text)
    except ValueError:
        words = f"must be a number of seconds, such as 0.002, got '{text}'"
        raise typer.BadParameter(words) from None


def _there_if_named(file: Path) -> Path:
    """Return the path of a result file; raise `typer.BadParameter` if there is no such file.

    `RESULT_FILE`, the default, need not exist.
    """
    if file != RESULT_FILE and not file.exists():
        raise typer.BadParameter(f"there is no file '{file}'")
    return file


Scenes = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENARIO|FOLDER",
        help="Files, folders, library scenes; the library if none.",
    ),
]
Scene = Annotated[str, typer.Argument(metavar="SCENARIO", help="A file or a library scene.")]
Stored = Annotated[
    Path, typer.Argument(metavar="[RESULT FILE]", help="What 'spincheck run' wrote.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
AsCsv = Annotated[bool, typer.Option("--csv", help="Print CSV.")]
Engines = Annotated[
    list[str] | None,
    typer.Option(
        "--engine",
        metavar="ENGINE",
        help="Only this engine; may be repeated. 'all': every installed one, 'node': those under "
        "node, 'mujoco@3.1.6': a version, 'MODULE:CLASS': one of your own, 'child:COMMAND': one in "
        "another language. If left out, "
        "MuJoCo, PyBullet, and others that 'spincheck engines' does not list as optional.",
    ),
]
Python = Annotated[
    str,
    typer.Option(
        metavar="COMMAND", help="The interpreter that versions run under, such as python3.12."
    ),
]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        "--method", metavar="METHOD", help="Only this method, in any case; may be repeated."
    ),
]
Timesteps = Annotated[
    list[float] | None,
    typer.Option(
        "--timestep",
        parser=_seconds,
        metavar="S",
        help="Run at this timestep, s, and not at halved ones; may be repeated.",
    ),
]
Timestep = Annotated[
    float, typer.Option("--timestep", parser=_seconds, metavar="S", help="The timestep, s.")
]
Jobs = Annotated[int, typer.Option("--jobs", metavar="N", min=1, help="Worker processes.")]
TimeLimit = Annotated[
    float | None,
    typer.Option("--time-limit", metavar="S", help="CPU seconds that a run may take: 120."),
]
Out = Annotated[Path, typer.Option("--out", metavar="FILE", help="The result file; added to.")]
From = Annotated[
    Path,
    typer.Option(
        "--from",
        metavar="RESULT FILE",
        callback=_there_if_named,
        help="Runs are taken from this file.",
    ),
]
MemberCount = Annotated[
    int | None,
    typer.Option(
        "--ensemble",
        metavar="[N]",
        min=1,
        help=f"Scatter each scene into N members, {MEMBERS} if left out, at stock timesteps.",
    ),
]
AsEncoded = Annotated[
    str,
    typer.Option(
        "--as",
        metavar="ENCODINGS",
        help="Run each body also in other descriptions that mean the same: 'all', or names of "
        "'spincheck engines --encodings' with commas between.",
    ),
]
Seed = Annotated[
    int | None,
    typer.Option("--seed", metavar="N", min=0, help="The seed of an ensemble's random numbers: 0."),
]
Again = Annotated[
    bool, typer.Option("--again", help="Run what the result file holds already, too.")
]
Device = Annotated[
    str,
    typer.Option(
        "--device", metavar="NAME", help="Step the batches of '--worlds' there, such as cuda:0."
    ),
]
Worlds = Annotated[
    str,
    typer.Option(
        "--worlds",
        metavar="N,N,…",
        help="Compare a world in batches of so many, such as 1,64,4096, with the same world alone.",
    ),
]
