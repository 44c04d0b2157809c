"""The commands of sweeps; heavy imports wait inside them, so that ``--help`` answers at once."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import (
    CORES,
    RESULT_FILE,
    Again,
    AsJson,
    Dask,
    Engines,
    Jobs,
    Methods,
    Scene,
    Seed,
    SweepTimesteps,
    TimeLimit,
)
from ..terminal import say, to_json

if TYPE_CHECKING:
    from ...results.sweep_records import SweepResult

app = typer.Typer()


@app.command(
    "map",
    epilog="Example: spincheck map fast-top --vary body.mass=1:2 --vary timestep=1e-4:1e-1:log",
)
def map_scene(
    scenario: Scene,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=LO:HI[:COUNT][:log]",
            help="A number of the scene file, as start.omega_body[2], or timestep; to be repeated "
            "once.",
        ),
    ] = None,
    engine: Engines = None,
    method: Methods = None,
    timestep: SweepTimesteps = None,
    jobs: Jobs = CORES,
    time_limit: TimeLimit = None,
    dask: Dask = None,
    out: Annotated[Path, typer.Option(help="The result file; added to.")] = RESULT_FILE,
    again: Again = False,
    as_json: AsJson = False,
) -> None:
    """Vary two numbers of a scene, and compare every method with the exact motion at every point.

    Points that the file has already are not run again, unless '--again' is given.
    """
    from ..choosing import Where
    from .sweep_running import choose_for_sweep, run_map

    choice = choose_for_sweep(engine or [], method or [], timestep or [], time_limit, again=again)
    swept = run_map(scenario, vary or [], choice, Where(jobs, dask), out)
    raise typer.Exit(print_swept(swept, f"Points are in {out}", out, as_json))


@app.command("vary", epilog="Example: spincheck vary fast-top 'start.omega_body[2]=37.3'")
def print_varied(
    scenario: Scene,
    numbers: Annotated[
        list[str],
        typer.Argument(metavar="PATH=VALUE", help="Numbers of the scene file, and values."),
    ],
) -> None:
    """Print a scene with other numbers, such as a point of a map, as a scenario file."""
    from .sweep_running import varied_text

    print(varied_text(scenario, numbers), end="")


@app.command("member", epilog="Example: spincheck member fast-top --seed 7 --member 3")
def print_member(
    scenario: Scene,
    member: Annotated[int, typer.Option(min=0, help="The member's number, from 0 on.")],
    seed: Seed = None,
) -> None:
    """Print one member of an ensemble as a scenario file, to be read and run."""
    from .sweep_running import member_text

    print(member_text(scenario, seed or 0, member), end="")


def print_swept(swept: "list[SweepResult]", where: str, out: Path, as_json: bool) -> int:
    """Print sweeps, a single one or a list of them; returns the exit code."""
    from .sweep_running import exit_code, print_sweep, sweep_as_json

    if as_json:
        records = [sweep_as_json(one) for one in swept]
        print(to_json(records[0] if len(records) == 1 else records))
    else:
        for one in swept:
            print_sweep(one)
        say(f"{where}; 'spincheck report {out}' draws them.")
    return exit_code(point for one in swept for point in one.points)
