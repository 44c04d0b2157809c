"""The option `--worlds`: compares worlds in batches with the same world alone, and prints it.

A world is one simulation of a scene; some engines step many of them at once, in a batch.
"""

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from math import isfinite
from typing import Any

from ....engines import Batch, Engine, engines
from ...harness.timesteps.stock import stock_timestep
from ...harness.varied.batches import Apart, BatchRow, batch_by, device_by
from ...pages.analysis.wording import duration
from ..choosing import check_timesteps, choose, executor_for
from ..named_scenes import scenes_to_run
from ..terminal import AGREES, DISAGREES, NOT_RUN, Complaint, say, table
from .summary import WIDTH

#: Largest number of worlds in a batch.
MOST = 1 << 20


def named_worlds(text: str) -> list[int]:
    """Return the sizes of batches, in worlds and ascending, from a text such as "1,64,4096".

    A `Complaint` is raised unless they are whole numbers from 1 to `MOST`.
    """
    try:
        found = sorted({int(part) for part in text.split(",")})
    except ValueError:
        found = [0]
    if not all(1 <= one <= MOST for one in found):
        raise Complaint(
            f"'--worlds' must be numbers from 1 to {MOST} with commas between, got '{text}'"
        )
    return found


def batches(
    scenes: Sequence[str],
    engine_names: Sequence[str],
    methods: Sequence[str],
    timesteps: Sequence[float],
    worlds: Sequence[int],
    device: str,
    time_limit: float | None,
) -> list[BatchRow]:
    """Return comparisons of worlds that are stepped in batches with the same world stepped alone.

    A world is one copy of a scene.

    Parameters
    ----------
    scenes : files, folders or names of library scenes, at least one
    engine_names : names of engines; if empty, all that are not optional
    methods : names of methods; if empty, all but those as shipped
    timesteps : s; if empty, the stock timestep of each engine
    worlds : numbers of worlds in a batch
    device : where batches are stepped, such as "cuda:0"; the default device if empty
    time_limit : CPU time that a run may take, s; the default if None

    Returns
    -------
    A row for each scene, method, timestep and number of worlds.

    Raises
    ------
    Complaint
        If a name or number cannot be used, if an engine cannot step batches, or if it lacks the
        device.
    """
    if not scenes:
        raise Complaint("'--worlds' needs a scene, such as fast-top")
    scenarios = scenes_to_run(scenes)
    chosen = choose(engine_names, methods, timesteps, scenarios=scenarios, time_limit=time_limit)
    for engine in chosen.engines:
        _check_batches(engine)
    check_timesteps(scenarios, chosen)
    rows: list[BatchRow] = []
    with executor_for(1, chosen) as executor:
        for engine in chosen.engines if device else ():
            if reason := device_by(executor, engine, device):
                raise Complaint(f"'--device': {reason}")
        for scenario in scenarios:
            for engine, method in chosen.methods_on(scenario).values():
                if method.as_shipped and not methods:
                    continue
                for timestep in timesteps or [stock_timestep(engine)]:
                    for count in worlds:
                        named = scenario.name, engine.name, method.name
                        say(f"{scenario.name}  {engine.name} {method.name}, {_worlds(count)}")
                        begun = BatchRow(*named, timestep, count, device or Batch.device)
                        rows.append(batch_by(executor, scenario, engine, begun))
    return rows


def _check_batches(engine: Engine) -> None:
    """Raise a `Complaint` if an engine cannot step batches of worlds."""
    if not engine.has_batches:
        able = ", ".join(one.name for one in engines().values() if one.has_batches)
        raise Complaint(
            f"'--worlds': {engine.name} steps one world at a time; "
            + (f"'--engine' may be {able}" if able else "no engine here steps more")
        )


def print_batches(rows: Sequence[BatchRow]) -> None:
    """Print a table of batches for each scene, method and timestep, with conclusions below it.

    Batches that could not be compared are listed with the reason.
    """
    for (scene, engine, method, timestep), group in groupby(
        rows, key=lambda row: (row.scene, row.engine, row.method, row.timestep)
    ):
        found = list(group)
        print(f"{scene}, {engine} {method} at {duration(timestep)}")
        compared = [row for row in found if not row.reason]
        table([_line(row) for row in compared])
        for line in [*_conclusions(compared), *_failures(found)]:
            print(textwrap.fill(line, WIDTH, subsequent_indent="  ", break_on_hyphens=False))
        print()


def batches_as_json(rows: Sequence[BatchRow]) -> list[dict[str, Any]]:
    """Return each row as a dictionary, for JSON: its attributes by name, nested ones too."""
    return [asdict(row) for row in rows]


def exit_code(rows: Sequence[BatchRow]) -> int:
    """Return the exit code: 3 if no batch could be compared, else 1 or 0.

    It is 1 if the motion of a world depends on its batch, or if a batch failed.
    """
    if all(row.reason for row in rows):
        return NOT_RUN
    wrong = any(row.because or row.outcome == "failed" for row in rows)
    return DISAGREES if wrong else AGREES


def _line(row: BatchRow) -> dict[str, object]:
    """Return a batch as a row of a table: how far its worlds' motions are off, and costs of steps.

    The motions are compared with that of the world stepped alone, with each other, and with those
    beside odd neighbours: worlds of other scenes in the same batch.
    """
    assert row.seconds_per_step is not None, "only a row that was compared is printed"
    return {
        "worlds": row.worlds,
        "from it alone": _words(row.alone),
        "between places": _words(row.place) if row.worlds > 1 else "",
        "odd neighbours": _words(row.neighbours) if row.has_neighbours else "",
        "until": f"{row.until:.3g} s",
        "a step": duration(row.seconds_per_step),
        "a world": duration(row.seconds_per_step / row.worlds),
    }


def _words(apart: Apart | None) -> str:
    """Return, in words, how far two motions of a world are apart.

    `apart` is None if they agree to the last bit.
    """
    if not apart:
        return "same bits"
    return f"{apart.ulp:.2g} ulp, {apart.degrees:.1g}°" if isfinite(apart.ulp) else "not finite"


def _conclusions(rows: Sequence[BatchRow]) -> Iterator[str]:
    """Yield a sentence on what a world's motion depends on, and one on what its steps cost.

    The cost of a world's step is compared with that of a step of `BatchRow.beside_by`, an engine
    that steps one world on one core.

    Parameters
    ----------
    rows : the batches of one method that were compared
    """
    if not rows:
        return
    if because := list(dict.fromkeys(word for row in rows for word in row.because)):
        yield (
            f"A world's motion depends on {', '.join(because)}: ulp where it first differs, "
            "degrees at the end."
        )
    else:
        yield "A world moves the same, to the last bit, in each of these batches."
    beside = min((row.beside for row in rows if row.beside), default=None)
    if beside is None:
        return
    costs = {row.worlds: (row.seconds_per_step or 0.0) / row.worlds for row in rows}
    cheaper = [count for count, cost in costs.items() if cost < beside]
    dearer = [count for count in costs if count not in cheaper]
    if not cheaper:
        which = f"with up to {_worlds(max(costs))}"
    elif min(cheaper) > max(dearer, default=0):
        which = f"from {_worlds(min(cheaper))} on"
    else:
        which = f"with {', '.join(map(str, cheaper[:-1]))}{' or ' * (len(cheaper) > 1)}"
        which += _worlds(cheaper[-1])
    yield (
        f"On the {rows[0].device}, {which}, a world's step costs {'less' if cheaper else 'more'} "
        f"than one of {rows[0].beside_by}, {duration(beside)} on one core."
    )


def _failures(rows: Sequence[BatchRow]) -> Iterator[str]:
    """Yield a line for each batch that could not be compared, with the reason."""
    for row in rows:
        if row.reason:
            yield f"{_worlds(row.worlds)}: {row.reason}"


def _worlds(count: int) -> str:
    """Return a number of worlds in words, such as "64 worlds"."""
    return "1 world" if count == 1 else f"{count} worlds"
