"""The commands about users' own models: URDF, MJCF and USD files."""

from pathlib import Path
from typing import Annotated

import typer

from .options import AsJson
from .terminal import AGREES, DISAGREES, Complaint, to_json

app = typer.Typer()

Readers = Annotated[
    list[str] | None,
    typer.Option(
        "--engine",
        metavar="ENGINE",
        help="Only this engine, which must read model files, or a version of it, 'mujoco@3.3.7'; "
        "may be repeated. If left out, MuJoCo and PyBullet.",
    ),
]
Packages = Annotated[
    list[str] | None,
    typer.Option(
        "--package-path", metavar="NAME=DIR", help="Where package://NAME is; may be repeated."
    ),
]


@app.command(epilog="Example: spincheck inspect robot.urdf --json")
def inspect(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="URDF, MJCF or USD.")],
    engine: Readers = None,
    package_path: Packages = None,
    mend: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT", help="Write FILE so that engines hold what it states; inspect that too."
        ),
    ] = None,
    nearest: Annotated[
        bool, typer.Option("--nearest", help="With --mend: the nearest tensor that a body has.")
    ] = False,
    made_up: Annotated[
        bool, typer.Option("--made-up", help="With --mend: an inertia for moving links without.")
    ] = False,
    compose: Annotated[
        bool, typer.Option("--compose", help="With --mend: welded links as one body.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compare what engines hold of a model's links with what its file states.

    Exits with 1 if an engine holds something else or the file states what no body can have, with 2
    if a file cannot be read; the others are inspected all the same.
    """
    from ..users_models.mend import Wishes
    from .inspecting import (
        inspections,
        models,
        print_inspection,
        print_mended,
        record,
        write_mended,
    )

    if (nearest or made_up or compose) and mend is None:
        raise Complaint("'--nearest', '--made-up' and '--compose' say how '--mend OUT' writes")
    if mend is not None and {mend.absolute().parent} != {one.absolute().parent for one in files}:
        raise Complaint("'--mend' writes into the folder of FILE: meshes are named relative to it")
    if mend is not None and any(one.suffix.lower().startswith(".usd") for one in files):
        raise Complaint("'--mend' writes URDF and MJCF, not USD")
    if mend is not None and len(files) > 1:
        raise Complaint(f"'--mend' writes one file, got {len(files)}")
    if mend is not None and mend.exists():
        raise Complaint(f"{mend}: it exists already; remove it, or give '--mend' another name")
    model_files, unreadable = models(files, _packages(package_path or []))
    inspected = []
    for one in inspections(model_files, engine or []) if model_files else ():
        inspected.append(one)
        if not as_json:
            print_inspection(one)
    mended = None
    if mend is not None and inspected:
        wishes = Wishes(nearest, made_up, compose)
        mended, after = write_mended(inspected[0], mend, wishes, engine or [])
        inspected.append(after)
        if not as_json:
            print_mended(mended, *inspected)
    if as_json and inspected:
        records = [record(one) for one in inspected]
        if mended is not None:
            records[1]["changes"] = [vars(one) for one in mended.changes]
            records[1]["left"] = [vars(one) for one in mended.left]
        print(to_json(records[0] if len(files) == 1 and mended is None else records))
    if unreadable:
        raise Complaint("\n".join(unreadable))
    judged = inspected if mended is None else inspected[1:]
    raise typer.Exit(AGREES if all(one.is_well for one in judged) else DISAGREES)


@app.command("import", epilog="Example: spincheck import robot.urdf --out scenes")
def import_links(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="URDF, MJCF or USD.")],
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
    """Return the names and folders of packages that the values of '--package-path' state.

    A `Complaint` is raised for a value that is not NAME=DIR with a folder that exists.
    """
    folders = []
    for one in options:
        name, equals, folder = one.partition("=")
        if not (name and equals and Path(folder).is_dir()):
            raise Complaint(
                f"'--package-path' takes NAME=DIR with a folder that is there, got '{one}'"
            )
        folders.append((name, Path(folder)))
    return tuple(folders)
