"""The commands that draw; heavy imports wait inside them, so that ``--help`` answers at once."""

from pathlib import Path
from typing import Annotated

import typer

from ..options import CORES, RESULT_FILE, From, Jobs, Scene

app = typer.Typer()

#: Where `view` writes.
VIEW_FOLDER = Path("spincheck-view")


@app.command(epilog="Example: spincheck view fast-top")
def view(
    scenario: Scene,
    jobs: Jobs = CORES,
    out: Annotated[Path, typer.Option(help="The folder to write.")] = VIEW_FOLDER,
) -> None:
    """Run one scene at a few timesteps, without timing, and write its page."""
    from .pictures import view as make_page

    print(make_page(scenario, jobs, out))


@app.command(epilog="Example: spincheck plot fast-top --what polhode -o polhode.svg")
def plot(
    scenario: Scene,
    what: Annotated[
        str,
        typer.Option(
            help="theta, omega, polhode, herpolhode, axis, potential, gains, convergence, "
            "work-precision."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="The file to write: .svg, .png, .pdf.")],
    results: From = RESULT_FILE,
    engine: Annotated[
        list[str] | None,
        typer.Option(metavar="ENGINE", help="Draw runs of this engine; may be repeated."),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(metavar="METHOD", help="Draw runs of this method; may be repeated."),
    ] = None,
) -> None:
    """Draw one figure of a scene as a file; needs matplotlib.

    It shows the exact motion, and of the result file the runs of engines and methods that are
    named; gains, convergence and work-precision show every method.
    """
    from .pictures import plot as draw

    draw(scenario, what, out, results, engine or [], method or [])
    print(out)
