"""Inspects a model: engines read it in a worker, their bodies are compared with the file's."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from ....engines import EngineError
from ....engines.checks.read_back import BodyReading
from ....engines.users_models import (
    AGREES,
    Configuration,
    ModelReader,
    cause,
    difference,
    model_readers,
    unstated_body,
)
from ....engines.versions import VersionError, versioned
from ....reference import IntegrationError, solve_ode
from ....scenarios import FloatArray, Scenario, did_you_mean, loads
from ....scenarios.body import body_about_com
from ....scenarios.exact import exact
from ....scenarios.users_models import (
    WORLD,
    FileProblem,
    Link,
    ModelFile,
    Pose,
    fused,
    problems,
    rigid_bodies,
    welded,
)
from ..executors import CallFailed, Executor
from .findings import TIMES, InspectedLink, Inspection, LinkReading

#: One turn a second about an axis that is none of the principal ones: ω along the file's principal
#: axes, ascending, rad/s.
START = 2 * np.pi * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
#: A scene to put the bodies into: free, from rest in its own axes.
_SCENE = """spincheck = 1
title = "Tumbling"
source = "docs/how-to/models.md"
[body]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
[start]
rotation_vector_deg = [0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, 0.0]
[window]
duration = 3.0
samples = 2
"""


def attitude_apart_deg(stated: FloatArray, got: FloatArray) -> dict[float, float] | None:
    """The angle between the two bodies after each of `TIMES` s, degrees.

    Parameters
    ----------
    stated, got : tensors about the com in the link's axes, (3, 3); a common factor has no effect

    Returns
    -------
    None if one of them is a tensor that no body can have
    """
    apart = attitude_apart(stated, got, np.array(TIMES))
    if apart is None:
        return None
    return {time: float(angle) for time, angle in zip(TIMES, np.degrees(apart), strict=True)}


def attitude_apart(stated: FloatArray, got: FloatArray, times: FloatArray) -> FloatArray | None:
    """The angle between the two bodies, rad, (n,); None as above.

    Parameters
    ----------
    times : s, (n,), at most the scene's 3
    """
    omega = np.linalg.eigh(stated)[1] @ START
    one, other = (_attitudes(tensor, omega, times) for tensor in (stated, got))
    if one is None or other is None:
        return None
    return np.asarray((one.inv() * other).magnitude())


def _attitudes(tensor: FloatArray, omega: FloatArray, times: FloatArray) -> Rotation | None:
    """The attitude at each time of a body that starts unturned.

    Solved along its principal axes: the reference would look for them in 60 digits.
    """
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    if not (total := float(moments.sum())) > 0:
        return None
    scene = _scene()
    x, y, z = exact(omega @ axes)
    try:
        body = body_about_com(1.0, (0.0, 0.0, 0.0), np.diag(moments / total).tolist())
        start = replace(scene.start, omega_body_exact=(x, y, z))
        moved = solve_ode(replace(scene, carrier=body, start=start), times)
    except (ValueError, IntegrationError):
        return None
    turn = Rotation.from_matrix(axes)
    return turn * moved.R_world_body * turn.inv()


@cache
def _scene() -> Scenario:
    return loads(_SCENE, "tumbling")


#: CPU s for one engine to read one file, meshes included; the largest take a few.
READ_LIMIT = 60.0

Bodies = dict[str, BodyReading]


class CannotInspectError(Exception):
    """There is no such engine, or none that reads this kind of file."""


@dataclass(frozen=True)
class ReaderEngine:
    """An engine that reads model files, at some version.

    Attributes
    ----------
    name : as users type it, "mujoco" or "mujoco@3.3.7"
    site : the folder it is installed in; empty for the version installed in this environment
    """

    name: str
    version: str
    site: str
    reader: ModelReader


def reader_engines(
    names: Sequence[str] = (), say: Callable[[str], object] = len
) -> list[ReaderEngine]:
    """The engines of those names; all that are installed if no name is given.

    An engine@version is installed first if necessary; `say` is given a sentence before.

    Raises
    ------
    CannotInspectError
        If there is no such engine, or version of it.
    """
    readers = model_readers()
    chosen = []
    for name in dict.fromkeys(names or readers):
        base, at, _ = name.partition("@")
        if base not in readers:
            raise CannotInspectError(
                f"'--engine' must be one of {', '.join(readers) or 'none'}, which read model "
                f"files, or a version of one, got '{name}'{did_you_mean(base, readers)}"
            )
        reader = readers[base]
        try:
            engine = versioned(name, say=say) if at else None
        except VersionError as error:
            raise CannotInspectError(f"'--engine' {error}") from None
        version, site = (engine.version, engine.site) if engine else (reader.version, "")
        chosen.append(ReaderEngine(name, version, site, reader))
    return chosen


def inspect_model(
    model: ModelFile, executor: Executor, engines: Sequence[ReaderEngine]
) -> Inspection:
    """Read a model with every configuration of some engines, and compare.

    Parameters
    ----------
    executor : makes the engines' readings, each in a child that may crash or hang

    Raises
    ------
    CannotInspectError
        If none of the engines reads this kind of file.
    """
    able = [engine for engine in engines if model.format in engine.reader.formats]
    if not able:
        names = ", ".join(engine.name for engine in engines) or "no installed engine"
        raise CannotInspectError(f"{names} cannot read {model.format.upper()}")
    faults = {link.name: problems(link) for link in model.links}
    readings: dict[str, list[LinkReading]] = {link.name: [] for link in model.links}
    refusals: dict[tuple[str, str], str] = {}
    for engine, setting in [
        (one, setting) for one in able for setting in one.reader.configurations
    ]:
        answer = executor.call_at(engine.site, read_held, engine.reader.name, model, setting.name)
        who = (engine.name, engine.version, setting.name)
        if isinstance(answer.value, CallFailed | str):
            reason = answer.value if isinstance(answer.value, str) else answer.value.reason
            refusals[engine.name, setting.name] = reason
            for name in readings:
                readings[name].append(LinkReading(*who, None, None, reason, "refused"))
            continue
        for link, one in _compared(model, answer.value, who, setting, faults):
            readings[link.name].append(one)
    links = [InspectedLink(li, faults[li.name], tuple(readings[li.name])) for li in model.links]
    composed = tuple(body for body in rigid_bodies(model.links) if body.welded)
    return Inspection(model, tuple(links), refusals, composed)


def read_held(engine: str, model: ModelFile, configuration: str) -> Bodies | str:
    """Run in a worker: the bodies that an engine holds, or why it refuses the file."""
    reader = model_readers().get(engine)
    if reader is None:
        return f"{engine} cannot be imported"
    try:
        return reader.read(model, configuration)
    except EngineError as error:
        return str(error)


def _compared(
    model: ModelFile,
    bodies: Bodies,
    who: tuple[str, str, str],
    configuration: Configuration,
    faults: dict[str, tuple[FileProblem, ...]],
) -> Iterator[tuple[Link, LinkReading]]:
    """Compare every link of the file with the body that one configuration holds."""
    gone = frozenset(link.name for link in model.links) - set(bodies)
    hosts = _hosts(model, gone)
    for link in model.links:
        body = bodies.get(link.name)
        if body is None:
            host = hosts[link.name]
            where = f"'{host}'" if host else "the world: it cannot move"
            reason = "" if link.name == WORLD else f"fused with {where}"
            yield link, LinkReading(*who, None, None, reason)
            continue
        parts = welded(model.links, link.name, gone)
        yield link, _link_reading(model, parts, body, who, configuration, faults)


def _link_reading(
    model: ModelFile,
    parts: list[tuple[Link, Pose]],
    body: BodyReading,
    who: tuple[str, str, str],
    configuration: Configuration,
    faults: dict[str, tuple[FileProblem, ...]],
) -> LinkReading:
    stated = [(link.stated, pose) for link, pose in parts if link.stated is not None]
    others = tuple(link.name for link, _ in parts[1:])
    if not stated:
        empty = body.mass == 0 and not body.inertia_com.any()
        if model.format == "mjcf":
            return LinkReading(
                *who, body, None, "" if empty else "taken from its shapes, as MJCF has it"
            )
        if empty:
            return LinkReading(*who, body, True, fused=others)
        return LinkReading(*who, body, False, unstated_body(body), "nothing stated", others)
    whole = fused(stated) if others else stated[0][0]
    apart = difference(whole, body)
    agrees = apart.worst <= AGREES
    wrong = tuple(problem for link, _ in parts for problem in faults[link.name])
    kind, sentence = cause(whole, body, apart, wrong, configuration.made_up)
    if others and kind in ("other", "turned", "rotation lost"):
        kind, sentence = "sum", f"the sum of its fused parts is wrong: {sentence}"
    return LinkReading(
        *who,
        body,
        agrees,
        "" if agrees else sentence,
        "" if agrees else kind,
        others,
        whole,
        apart,
        attitude_apart_deg(whole.inertia, body.inertia_com),
    )


def _hosts(model: ModelFile, gone: frozenset[str]) -> dict[str, str]:
    """The link that each one without a body of its own is fused with; empty for the world."""
    parents = {link.name: link.parent for link in model.links}
    hosts = {}
    for name in gone:
        host = parents[name]
        while host in gone:
            host = parents[host]
        hosts[name] = host
    return hosts
