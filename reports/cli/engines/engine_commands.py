"""Commands about engines: a list, their derivatives, one run to paste into an issue."""

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import AsJson, Engines, Methods, Scene, TimeLimit, Timestep
from ..terminal import Complaint, table, to_json

if TYPE_CHECKING:
    from ....engines import Engine

app = typer.Typer()

#: Width of a line, and of the column of methods' names in it, characters.
WIDTH, NAMES = 80, 26


@app.command("engines", epilog="Example: spincheck engines --encodings")
def list_engines(
    as_json: AsJson = False,
    encodings: Annotated[
        bool,
        typer.Option(
            "--encodings", help="List the descriptions of a body that 'run --as' compares."
        ),
    ] = False,
) -> None:
    """List engines, their methods, orders of accuracy and effects.

    'spincheck run --engine mujoco@3.1.6' installs that version, into a folder of its own.
    """
    from ....engines import engines, missing
    from ..run.encodings import encoding_rows

    if encodings:
        described = encoding_rows()
        print(to_json(described)) if as_json else table(described)
        return
    rows = [
        {
            "engine": engine.name,
            "version": engine.version,
            "method": method.name,
            "order": method.order,
            "attitude_order": method.attitude_order,
            "effects": ", ".join(sorted(method.effects)),
            "summary": method.summary,
        }
        for engine in engines().values()
        for method in engine.methods
    ]
    if as_json:
        absent = [{"engine": m.name, "package": m.package, "reason": m.reason} for m in missing()]
        print(to_json({"engines": rows, "missing": absent}))
        return
    for engine in engines().values():
        print("\n".join(_methods_of(engine)))
    for m in missing():
        reason = f"{m.name} cannot be used: {m.reason}."
        print(textwrap.fill(reason, WIDTH, subsequent_indent="  ", break_on_hyphens=False))


def _methods_of(engine: "Engine") -> Iterator[str]:
    """Yield a line for an engine, and one for each method with the effects that the method lacks.

    Long lines are wrapped. The last line is empty.
    """
    from ....scenarios import EFFECTS

    optional = f" (optional: runs only with '--engine {engine.name}')" if engine.is_optional else ""
    yield f"{engine.name} {engine.version}{optional}"
    for method in engine.methods:
        orders = f"order {method.order}"
        if method.attitude_order != method.order:
            orders += f", attitude {method.attitude_order}"
        lacking = [name for name in EFFECTS if name not in method.effects]
        without = f"; cannot simulate {', '.join(lacking)}" if lacking else ""
        yield from textwrap.wrap(
            f"{orders}; {method.summary}{without}",
            WIDTH,
            initial_indent=f"  {method.name:{NAMES}} ",
            subsequent_indent=" " * (NAMES + 3),
            break_on_hyphens=False,
        )
    yield ""


@app.command(epilog="Example: spincheck gradients fast-top --engine mujoco")
def gradients(
    scenes: Annotated[
        list[str],
        typer.Argument(metavar="SCENARIO|FOLDER", help="Files, folders or library scenes."),
    ],
    engine: Engines = None,
    method: Methods = None,
    timestep: Annotated[
        float | None,
        typer.Option("--timestep", metavar="S", help="The timestep of a window of many steps, s."),
    ] = None,
    window: Annotated[
        float | None,
        typer.Option("--window", metavar="S", help="The length of the window, s [512 steps]."),
    ] = None,
    time_limit: TimeLimit = None,
    as_json: AsJson = False,
) -> None:
    """Check engines' derivatives of their steps against those of the exact motion.

    Derivatives that an engine gives itself are checked, and central differences of its steps.
    Methods as shipped are left out unless they are named. Exits with 1 if a
    derivative is wrong or fails.
    """
    from .gradients import exit_code, gradients_as_json, print_gradients
    from .gradients import gradients as judge_gradients

    rows = judge_gradients(scenes, engine or [], method or [], timestep, window, time_limit)
    if as_json:
        print(to_json(gradients_as_json(rows)))
    else:
        print_gradients(rows)
    raise typer.Exit(exit_code(rows))


@app.command(
    epilog="Example: spincheck reproduce fast-top --engine mujoco --method Euler --timestep 2e-3"
)
def reproduce(
    scenario: Scene,
    engine: Annotated[
        str, typer.Option(metavar="ENGINE", help="One of 'spincheck engines', or mujoco@VERSION.")
    ],
    method: Annotated[str, typer.Option(metavar="METHOD", help="One of the engine's methods.")],
    timestep: Timestep,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The file to write.")] = None,
) -> None:
    """Write one run as a file that needs the engine alone, for an issue.

    It is Python with numpy, or JavaScript if the engine runs under node. It builds the model, steps
    it, and prints its error against the exact values that it contains.
    """
    from ..choosing import check_timesteps, choose
    from ..named_scenes import one_scene
    from ..own_files import write_own
    from .reproduce import FRAMES, reproduction

    scene = one_scene(scenario)
    choice = choose([engine], [method], [timestep])
    check_timesteps([scene], choice)
    if len(choice.pairs()) > 1:
        raise Complaint(f"'--engine' must name one engine, got '{engine}'")
    ((chosen, by),) = choice.pairs()
    text = reproduction(scene, chosen, by, timestep)
    suffix = FRAMES[chosen.script_language].suffix
    file = out or Path(f"{scene.name}-{chosen.name}-{by.name}{suffix}")
    write_own({file: text})
    print(file)
