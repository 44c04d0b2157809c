"""Inspects a model file: parse it here, read it with each engine in a child, compare."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ....engines import EngineError
from ....engines.model_reader import Configuration, ModelReader, model_readers
from ....engines.read_back import BodyReading
from ....scenarios.model_files import Link, ModelFile, Problem, fused, problems, read_model
from ....scenarios.model_files.model_file import Pose, welded
from ..executors import CallFailed, Executor
from .cause import cause, held_of_nothing
from .difference import difference
from .motion_apart import attitude_apart_deg
from .records import AGREES, Held, InspectedLink, Inspection

#: CPU s for one engine to read one file, meshes included; the largest take a few.
READ_LIMIT = 60.0
#: Links of a URDF that engines take for the world itself.
WORLD = "world"

Bodies = dict[str, BodyReading]


class CannotInspectError(Exception):
    """There is no such engine, or none that reads this kind of file."""


def inspect_model(
    path: Path,
    executor: Executor,
    engines: Sequence[str] = (),
    packages: tuple[tuple[str, Path], ...] = (),
) -> Inspection:
    """What every configuration of every engine holds of a file.

    Parameters
    ----------
    executor : makes the engines' readings, each in a child that may crash or hang
    engines : by name; all that are installed if empty
    packages : folders by the name that `package://` gives them

    Raises
    ------
    ModelFileError
        If the file cannot be read.
    CannotInspectError
        If no engine can be asked.
    """
    model = read_model(path, packages)
    readers = _readers(model, engines)
    faults = {link.name: problems(link) for link in model.links}
    held: dict[str, list[Held]] = {link.name: [] for link in model.links}
    refusals: dict[tuple[str, str], str] = {}
    for reader, configuration in readers:
        answer = executor.call(read_held, reader.name, model, configuration.name).value
        who = (reader.name, reader.version, configuration.name)
        if isinstance(answer, CallFailed | str):
            reason = answer if isinstance(answer, str) else answer.reason
            refusals[reader.name, configuration.name] = reason
            for name in held:
                held[name].append(Held(*who, None, None, reason))
            continue
        for link, one in _compared(model, answer, who, configuration, faults):
            held[link.name].append(one)
    links = [InspectedLink(li, faults[li.name], tuple(held[li.name])) for li in model.links]
    return Inspection(model, tuple(links), refusals)


def _readers(model: ModelFile, engines: Sequence[str]) -> list[tuple[ModelReader, Configuration]]:
    readers = model_readers()
    if unknown := sorted(set(engines) - set(readers)):
        raise CannotInspectError(
            f"no engine '{unknown[0]}' reads model files; there are {', '.join(readers) or 'none'}"
        )
    able = [
        reader
        for name, reader in readers.items()
        if name in (engines or readers) and model.format in reader.formats
    ]
    if not able:
        raise CannotInspectError(
            f"{', '.join(engines) or 'no installed engine'} cannot read {model.format.upper()}"
        )
    return [(reader, one) for reader in able for one in reader.configurations]


def read_held(engine: str, model: ModelFile, configuration: str) -> Bodies | str:
    """In a child: what an engine holds, or why it refuses the file."""
    try:
        return model_readers()[engine].read(model, configuration)
    except EngineError as error:
        return str(error)


def _compared(
    model: ModelFile,
    bodies: Bodies,
    who: tuple[str, str, str],
    configuration: Configuration,
    faults: dict[str, tuple[Problem, ...]],
) -> Iterator[tuple[Link, Held]]:
    """Every link of the file beside what one configuration has made of it."""
    gone = frozenset(link.name for link in model.links) - set(bodies)
    hosts = _hosts(model, gone)
    for link in model.links:
        body = bodies.get(link.name)
        if body is None:
            host = hosts[link.name]
            where = f"'{host}'" if host else "the world: it cannot move"
            reason = "" if link.name == WORLD else f"fused with {where}"
            yield link, Held(*who, None, None, reason)
            continue
        parts = welded(model.links, link.name, gone)
        yield link, _held(model, parts, body, who, configuration, faults)


def _held(
    model: ModelFile,
    parts: list[tuple[Link, Pose]],
    body: BodyReading,
    who: tuple[str, str, str],
    configuration: Configuration,
    faults: dict[str, tuple[Problem, ...]],
) -> Held:
    stated = [(link.stated, pose) for link, pose in parts if link.stated is not None]
    others = tuple(link.name for link, _ in parts[1:])
    if not stated:
        empty = body.mass == 0 and not body.inertia_com.any()
        if model.format == "mjcf":
            return Held(*who, body, None, "" if empty else "taken from its shapes, as MJCF has it")
        return Held(*who, body, empty, "" if empty else held_of_nothing(body), others)
    whole = fused(stated) if others else stated[0][0]
    apart = difference(whole, body)
    agrees = apart.worst <= AGREES
    wrong = tuple(problem for link, _ in parts for problem in faults[link.name])
    return Held(
        *who,
        body,
        agrees,
        "" if agrees else cause(whole, body, apart, wrong, configuration.made_up),
        others,
        whole,
        apart,
        attitude_apart_deg(whole.inertia, body.inertia_com),
    )


def _hosts(model: ModelFile, gone: frozenset[str]) -> dict[str, str]:
    """The link that each link that is gone is fused with; empty for the world."""
    parents = {link.name: link.parent for link in model.links}
    hosts = {}
    for name in gone:
        host = parents[name]
        while host in gone:
            host = parents[host]
        hosts[name] = host
    return hosts
