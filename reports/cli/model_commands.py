"""The commands about users' own models: URDF and MJCF files."""

from pathlib import Path
from typing import Annotated

import typer

from .options import AsJson, Engines
from .terminal import AGREES, DISAGREES, Complaint, say, to_json

app = typer.Typer()

Packages = Annotated[
    list[str] | None,
    typer.Option(
        "--package-path", metavar="NAME=DIR", help="Where package://NAME is; may be repeated."
    ),
]


@app.command(epilog="Example: spincheck inspect robot.urdf --json")
def inspect(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="URDF or MJCF.")],
    engine: Engines = None,
    package_path: Packages = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="The folder to write a page of each file into."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare what engines hold of a model's links with what its file states.

    Exits with 1 if an engine holds something else or the file states what no body can have, with 2
    if a file cannot be read; the others are inspected all the same.
    """
    from .inspecting import inspections, models, print_inspection, record, write_pages

    model_files, unreadable = models(files, _packages(package_path or []))
    inspected = []
    for one in inspections(model_files, engine or []) if model_files else ():
        inspected.append(one)
        if not as_json:
            print_inspection(one)
    if out is not None:
        for page in write_pages(inspected, out):
            say(str(page))
    if as_json and inspected:
        records = [record(one) for one in inspected]
        print(to_json(records[0] if len(files) == 1 else records))
    if unreadable:
        raise Complaint("\n".join(unreadable))
    raise typer.Exit(AGREES if all(one.is_well for one in inspected) else DISAGREES)


@app.command("import", epilog="Example: spincheck import robot.urdf --out scenes")
def import_links(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="URDF or MJCF.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Made if it is not there.")],
    link: Annotated[
        list[str] | None,
        typer.Option("--link", metavar="LINK", help="Only this link; may be repeated."),
    ] = None,
) -> None:
    """Write a scene for each link of a model, which tumbles with the inertia of the file."""
    from .inspecting import import_scenes

    for line in import_scenes(file, out, link or []):
        print(line)


def _packages(options: list[str]) -> tuple[tuple[str, Path], ...]:
    folders = []
    for one in options:
        name, equals, folder = one.partition("=")
        if not (name and equals and Path(folder).is_dir()):
            raise Complaint(
                f"'--package-path' takes NAME=DIR with a folder that is there, got '{one}'"
            )
        folders.append((name, Path(folder)))
    return tuple(folders)
