"""The command `judge`; heavy imports wait inside it, so that ``--help`` answers at once."""

from pathlib import Path
from typing import Annotated

import typer

from ..options import AsJson, Scene
from ..terminal import Complaint, say, to_json

app = typer.Typer()


@app.command(epilog="Example: spincheck judge fast-top motion.csv --omega world")
def judge(
    scenario: Scene,
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE", help="Recorded motions: CSV, JSON lines, npz, Parquet."),
    ],
    quaternion: Annotated[
        str | None,
        typer.Option(metavar="wxyz|xyzw", help="The order of components; wxyz if left out."),
    ] = None,
    omega: Annotated[
        str | None, typer.Option(metavar="body|world", help="The axes of ω; body if left out.")
    ] = None,
    timestep: Annotated[
        list[float] | None,
        typer.Option("--timestep", metavar="S", help="The timestep of a file, s; may be repeated."),
    ] = None,
    order: Annotated[
        int, typer.Option(min=1, max=12, help="The order of accuracy of the method that made them.")
    ] = 1,
    noise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SIGNAL=SIZE",
            help="The standard deviation of measured numbers: attitude=0.3deg, omega=0.02 (rad/s); "
            "may be repeated. Estimated if left out.",
        ),
    ] = None,
    fail_above: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SIGNAL=BOUND",
            help="Exit with 1 if an error is larger: attitude=1deg, omega=1e-3; may be repeated.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The folder to write a page into.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare recorded motions with the exact one.

    A file's columns are t, qw qx qy qz (body to world), wx wy wz and, if there, x y z, vx vy vz, in
    SI units or with the unit behind the name, as in 'wx [deg/s]'. Several files at halved timesteps
    are judged as the timesteps of one method.
    """
    from ...harness.recorded.files.read import READERS
    from ..named_scenes import one_scene
    from .judging import judged_files, judgement_as_json, print_judgement, write_page

    if Path(scenario).suffix in READERS:
        raise Complaint(f"{scenario}: a recording; the scene comes first, then its recordings")
    options = (quaternion, omega, timestep or [], fail_above or [], noise or [], order)
    judgement = judged_files(one_scene(scenario), files, *options)
    if as_json:
        print(to_json(judgement_as_json(judgement)))
    else:
        print_judgement(judgement)
    if out is not None:
        say(str(write_page(judgement, out)))
    raise typer.Exit(judgement.exit_code)
