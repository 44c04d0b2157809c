"""The command line. Heavy imports wait inside the commands, so that ``--help`` answers at once."""

import sys
from importlib.metadata import version
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any

import typer

from ..results.verdict_words import UNPROVEN
from .engines.engine_commands import app as engine_commands
from .grouped import EnsembleCommand, ErrorBoundsCommand, GroupedCommands, error_bounds
from .judge.judge_command import app as judge_command
from .model_commands import app as model_commands
from .options import (
    CORES,
    REPORT_FOLDER,
    RESULT_FILE,
    Again,
    AsEncoded,
    AsJson,
    Device,
    Engines,
    From,
    Jobs,
    MemberCount,
    Methods,
    Out,
    Python,
    Scene,
    Scenes,
    Seed,
    TimeLimit,
    Timesteps,
    Worlds,
)
from .results.result_commands import app as result_commands
from .scenes.scene_commands import app as scene_commands
from .stopping import (
    STDOUT,
    Stopped,
    open_closed_streams,
    print_nowhere,
    raise_when_stopped,
    say_last_words,
)
from .terminal import (
    NOT_RUN,
    Complaint,
    command,
    escape_what_turns_text,
    refusal,
    say,
    to_json,
    unusable,
)


class Commands(GroupedCommands):
    """The group of all commands, which ends with `NOT_RUN` if nobody reads what a command prints.

    typer would end with 1, which says that something disagrees.
    """

    def invoke(self, ctx: Any) -> Any:
        """Run a command, and return what it returns."""
        try:
            try:
                return super().invoke(ctx)
            finally:
                sys.stdout.flush()
        except BrokenPipeError:
            print_nowhere(STDOUT)
            raise typer.Exit(NOT_RUN) from None


app = typer.Typer(
    name="spincheck",
    help="Check physics engines against the exact motion of spinning tops.",
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.add_typer(judge_command)
app.add_typer(result_commands)
app.add_typer(scene_commands)
app.add_typer(engine_commands)
app.add_typer(model_commands)


def _print_version(wanted: bool) -> None:
    """Print the version and exit if the option `--version` was given."""
    if wanted:
        print(f"spincheck {version('spincheck')}")
        raise typer.Exit


@app.callback()
def spincheck(
    _: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Check physics engines against the exact motion of spinning tops."""


def main() -> None:
    """Run the command line; a `Complaint` ends it with one message on stderr and an exit code."""
    # The text may have Greek letters of a title, or bytes of a file's name, that the terminal's
    # encoding lacks.
    open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
        escape_what_turns_text(stream)
    try:
        raise_when_stopped()
        _run_and_flush()
    except Complaint as complaint:
        say(f"spincheck: {complaint}")
        sys.exit(complaint.exit_code)
    except Stopped as stopped:
        say_last_words(stopped.number)
        sys.exit(stopped.exit_code)


def _run_and_flush() -> None:
    """Run the command line; turn an error that is no fault of the program into a `Complaint`.

    `refusal` tells which errors these are.
    """
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except Complaint:
        raise
    except Exception as error:
        if complaint := refusal(error):
            raise complaint from None
        raise


@app.command(cls=EnsembleCommand, epilog="Example: spincheck run fast-top --engine mujoco")
def run(
    scenes: Scenes = None,
    engine: Engines = None,
    method: Methods = None,
    timestep: Timesteps = None,
    as_encoded: AsEncoded = "",
    jobs: Jobs = CORES,
    out: Out = RESULT_FILE,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Fewer timesteps, without timing; hard scenes only if named."),
    ] = False,
    time_limit: TimeLimit = None,
    python: Python = "",
    ensemble: MemberCount = None,
    seed: Seed = None,
    worlds: Worlds = "",
    device: Device = "",
    strict: Annotated[
        bool,
        typer.Option("--strict", help=f"Exit with 1 also if a verdict is {UNPROVEN}."),
    ] = False,
    again: Again = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Print every verdict, with its reason.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Simulate scenes, compare with the exact motion, and store the results.

    '--ensemble' runs many scattered scenes instead, each at one timestep. '--worlds' compares
    worlds in batches with the same world alone instead, and stores nothing.

    Results that the file has already are not made again, unless the scene, the engine or spincheck
    has changed since, the run failed because of the machine, or '--again' is given.
    """
    from .run import running
    from .run.batches import batches, batches_as_json, named_worlds, print_batches
    from .run.batches import exit_code as exit_code_of_batches
    from .run.encodings import named_encodings
    from .run.ensembles import choose_for_ensemble, exit_code_of, print_ensembles, run_ensembles
    from .run.short_summary import short_summary
    from .run.summary import results_as_json, verdict_lines

    named = (engine or [], method or [], timestep or [])
    if seed is not None and ensemble is None:
        raise Complaint("'--seed' is for an ensemble; '--ensemble' scatters a scene into one")
    if device and not worlds:
        raise Complaint("'--device' is for batches; '--worlds' steps a scene in some")
    of_ladders = {"--quick": quick, "--as": as_encoded, "--strict": strict}
    is_not = "is for ladders; '--ensemble' has none"
    if worlds:
        of_ladders |= {"--ensemble": ensemble, "--python": python}
        is_not = "is not for '--worlds', which compares batches with worlds alone"
    for option, is_given in of_ladders.items() if worlds or ensemble else ():
        if is_given:
            raise Complaint(f"'{option}' {is_not}")
    if worlds:
        rows = batches(scenes or [], *named, named_worlds(worlds), device, time_limit)
        if as_json:
            print(to_json(batches_as_json(rows)))
        else:
            print_batches(rows)
        raise typer.Exit(exit_code_of_batches(rows))
    if ensemble is not None:
        choice = choose_for_ensemble(*named, time_limit, again=again, python=python)
        swept = run_ensembles(scenes or [], ensemble, seed or 0, choice, jobs, out)
        print_ensembles(swept, out, as_json)
        raise typer.Exit(exit_code_of(swept))
    results = running.run(
        scenes or [],
        *named,
        jobs,
        out,
        quick=quick,
        time_limit=time_limit,
        again=again,
        python=python,
        encodings=named_encodings(as_encoded),
    )
    if as_json:
        print(to_json(results_as_json(results)))
    else:
        every = verdict_lines(results.verdicts) if verbose else ()
        for line in (*every, *short_summary(results, out, timestep or [])):
            print(line)
        say(f"Results are in {out}; '{command('report', out)}' makes pages of them.")
        if unproven := running.unproven_in_words(results):
            say(unproven)
    running.say_where_motions_end(results)
    running.tell_untrue(results)
    raise typer.Exit(running.exit_code(results, strict=strict))


@app.command(epilog="Example: spincheck report spincheck.sqlite --out pages")
def report(
    results: Annotated[
        Path | None, typer.Argument(metavar="[RESULT FILE]", help="What 'spincheck run' wrote.")
    ] = None,
    scene: Annotated[
        str, typer.Option("--scene", metavar="SCENE", help="Make pages of this scene alone.")
    ] = "",
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder to write.")] = REPORT_FOLDER,
) -> None:
    """Make HTML and Markdown pages of a result file.

    A button on each figure saves it as SVG. Exit code 1: a verdict in the file
    disagrees or failed, of a method that is not as shipped; the pages are
    written all the same.
    """
    from ..pages.render import render
    from .run import running

    stored = running.read(results or RESULT_FILE, scene.removesuffix(".toml"))
    try:
        print(f"The report is {render(stored, out)}")
    except OSError as error:
        raise unusable(out, error, "written") from None
    running.tell_untrue(stored)
    raise typer.Exit(running.exit_code(stored))


@app.command(epilog="Example: spincheck compare before.sqlite after.sqlite")
def compare(
    old: Annotated[
        str, typer.Argument(metavar="OLD", help="A result file, or ENGINE@VERSION in '--from'.")
    ],
    new: Annotated[str, typer.Argument(metavar="NEW", help="Another one, made later.")],
    stored: From = RESULT_FILE,
    as_json: AsJson = False,
) -> None:
    """Show what changed between two result files, or two versions of an engine in one.

    Exits with 1 if anything got worse.
    """
    from .results.compare import changes_as_json, exit_code, print_changes
    from .results.compare import compare as find_changes

    changed = find_changes(old, new, stored)
    if as_json:
        print(to_json(changes_as_json(changed)))
    else:
        print_changes(changed)
    raise typer.Exit(exit_code(changed))


@app.command(cls=ErrorBoundsCommand, epilog="Example: spincheck recommend fast-top --omega 1e-4")
def recommend(
    context: typer.Context,
    scenario: Scene,
    engine: Engines = None,
    stored: From = RESULT_FILE,
    as_json: AsJson = False,
) -> None:
    """Find the cheapest method and timestep that stay within bounds, and check it by a run.

    Without bounds it takes those of a report: attitude to 0.1deg and ω to 0.001. It uses the timed
    runs of the scene in the result file, and runs the scene if there are none, or
    none of an engine that '--engine' names.
    An engine as shipped, with its damping and clamps, is never recommended.
    """
    from .named_scenes import one_scene
    from .run.recommend import exit_code
    from .run.recommend import recommend as find_cheapest
    from .run.recommendation_words import print_recommendation, recommendation_as_json

    one_scene(scenario)
    bounds = error_bounds(context)
    recommendation = find_cheapest(scenario, bounds, engine or [], CORES, stored)
    if as_json:
        print(to_json(recommendation_as_json(recommendation)))
    else:
        print_recommendation(recommendation)
    raise typer.Exit(exit_code(recommendation))
