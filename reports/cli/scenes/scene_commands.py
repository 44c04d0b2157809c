"""The commands about scenes; heavy imports wait inside them, so that ``--help`` answers at once."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..options import AsJson, Scene, Scenes, Seed
from ..terminal import (
    BAD_INPUT,
    DISAGREES,
    NOT_RUN,
    Complaint,
    command,
    print_file,
    table,
    to_json,
)

app = typer.Typer()


@app.command(epilog="Example: spincheck reference fast-top --at 0.5 --at 1 --json")
def reference(
    scenario: Scene,
    at: Annotated[
        list[float] | None, typer.Option("--at", metavar="S", help="A time, s; may be repeated.")
    ] = None,
    sensitivities: Annotated[
        bool, typer.Option("--sensitivities", help="Its derivatives by start and parameters too.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the exact motion: states, L, energy, invariants, and how exact they are."""
    from ...harness.scene_checks.published import published_that_do_not_hold
    from .exact_motion import describe, print_truth

    scene = _scenario(scenario)
    truth = describe(scene, at or [], sensitivities)
    if as_json:
        print(to_json(truth))
    else:
        print_truth(truth)
    if untrue := list(published_that_do_not_hold(scene)):
        raise Complaint("\n".join(untrue), DISAGREES)


@app.command("list", epilog="Example: spincheck list hard")
def list_scenes(scenes: Scenes = None, as_json: AsJson = False) -> None:
    """List scenes with what they are about."""
    from ..named_scenes import complain, listed

    rows, wrong = listed(scenes or [])
    print(to_json(rows)) if as_json else table(rows)
    complain(wrong)


@app.command(epilog="Example: spincheck new my-top")
def new(name: Annotated[str, typer.Argument(metavar="NAME", help="The scene's name.")]) -> None:
    """Write NAME.toml, a scene to edit, with every key explained."""
    from .scene import new_scene

    path = new_scene(name)
    print(f"{path} is written. Edit it, then: {command('run', path)}")


@app.command(epilog="Example: spincheck show fast-top --toml")
def show(
    scenario: Scene,
    member: Annotated[
        int | None,
        typer.Option("--member", metavar="N", min=0, help="This member of an ensemble, from 0 on."),
    ] = None,
    seed: Seed = None,
    toml: Annotated[bool, typer.Option("--toml", help="Print the scene's file.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show a scene as it was read, in SI units, with defaults; with --json in all digits."""
    from ..run.ensembles import member_of
    from .scene import scene_as_json, scene_rows

    if toml and as_json:
        raise Complaint("takes '--toml' or '--json', not both")
    scene = member_of(scenario, member, seed)
    if toml:
        print_file(scene.text)
    elif as_json:
        print(to_json(scene_as_json(scene)))
    else:
        print(f"{scene.title}\n\n{scene.document.description}\n")
        if scene.path:
            print(f"{scene.path}\n")
        table([*scene_rows(scene)])


@app.command(epilog="Example: spincheck check my-top.toml")
def check(
    scenes: Annotated[
        list[str],
        typer.Argument(metavar="SCENARIO|FOLDER", help="Files, folders or library scenes."),
    ],
) -> None:
    """Check scenes: format, published values, and effects without which nothing would change.

    Prints mass, tilt and speed, in which a wrong unit is seen.
    """
    from ..named_scenes import checked

    result = checked(scenes)
    for line in [*result.lines, *result.powerless]:
        print(line)
    if failed := [*result.wrong, *result.unsolved, *result.untrue]:
        code = BAD_INPUT if result.wrong else NOT_RUN if result.unsolved else DISAGREES
        raise Complaint("\n".join(failed), code)


@app.command(epilog="Example: spincheck export fast-top models")
def export(
    scenario: Scene,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Made if it is not there.")],
    truth: Annotated[
        bool, typer.Option("--truth", help="The exact motion instead, as truth.csv.")
    ] = False,
    sensitivities: Annotated[
        bool, typer.Option("--sensitivities", help="With --truth: sensitivities.json as well.")
    ] = False,
) -> None:
    """Write a scene as scene.xml (MJCF) and scene.urdf, or its exact motion.

    The MJCF uses RK4; its timestep is 0.05 rad over the fastest rate at the start. A driven hinge
    has an armature so large that its speed does not change. Files of these names are replaced
    only if spincheck has written them.
    """
    from ..own_files import write_own
    from .exact_motion import truth_files
    from .scene import model_files

    if sensitivities and not truth:
        raise Complaint("'--sensitivities' goes with '--truth', which is missing; add it")
    scene = _scenario(scenario)
    texts = truth_files(scene, sensitivities) if truth else model_files(scene)
    write_own({folder / name: text for name, text in texts.items()})
    for name in texts:
        print(folder / name)


def _scenario(name: str) -> Any:
    """Return the scene that a file's path or the name of a library scene stands for.

    A `Complaint` is raised if there is none, or if there are several.
    """
    from ..named_scenes import one_scene

    return one_scene(name)
