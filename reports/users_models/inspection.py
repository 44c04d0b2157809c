"""Inspects a model: engines read it in workers, and their bodies are compared with the file's."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...engines import BodyReading, EngineError
from ...engines.model_readers import model_readers
from ...engines.users_models import (
    WORLD,
    BodyDifference,
    Configuration,
    FileProblem,
    Link,
    ModelFile,
    ModelReader,
    RigidBody,
    Stated,
    compared,
    problems,
    rigid_bodies,
    unstated_body,
)
from ...engines.versions import VersionError, versioned
from ...reference import IntegrationError, solve_ode
from ...scenarios import FloatArray, did_you_mean, loads
from ..harness.executors import CallFailed, Executor

#: Times after which the motions of the file's and the engine's body are compared, s.
TIMES = (1.0, 3.0)
#: ω at the start, rad/s, along the file's principal axes in the order of ascending moments: one
#: turn a second about an axis that is no principal axis.
START = 2 * np.pi * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
#: A scene with a free body, whose tensor is diagonal: for another one the reference would compute
#: the principal axes to 60 digits, which takes long.
_SCENE = """spincheck = 1
title = "Tumbling"
source = "docs/how-to/models.md"
[body]
mass = 1.0
inertia = {}
[start]
rotation_vector_deg = [0.0, 0.0, 0.0]
omega_body = {}
[window]
duration = 3.0
samples = 2
"""
#: Largest angle between two such motions that rounding alone may cause, rad.
ROUNDING = 1e-10
#: CPU time that an engine may take to read a file with its meshes, s; the largest files take a few
#: seconds.
READ_LIMIT = 60.0


@dataclass(frozen=True, eq=False)
class LinkReading:
    """One link as one engine holds it, in one of its configurations.

    Attributes
    ----------
    body : the body that the engine holds; None if the engine refused the file, or fused the link
        with another
    agrees : whether the body is the one that the file states; None if they cannot be compared
    cause : in words, how the body differs and why, or why it cannot be compared; empty if it agrees
    kind : the cause in a word: "refused" if the engine refused the file, "unread" if the body has
        parts that were not read from the file, "nothing stated" if the file states no body, "sum"
        if the sum of fused links is wrong, else the word that `compare.cause` returns; empty if the
        body agrees or if there is nothing to compare it with
    fused : names of the links that the engine has fused with this one
    expected : the body that the file states for this link and those fused with it; None if it
        states none, or if the engine holds no body
    difference : the difference of `body` from `expected`; None if they cannot be compared
    attitude_apart_deg : angle between the attitudes of the file's and the engine's body, degrees,
        by time, s, if both tumble from the same start; None if there is no such motion
    """

    engine: str
    engine_version: str
    configuration: str
    body: BodyReading | None
    agrees: bool | None
    cause: str = ""
    kind: str = ""
    fused: tuple[str, ...] = ()
    expected: Stated | None = None
    difference: BodyDifference | None = None
    attitude_apart_deg: dict[float, float] | None = None

    @property
    def column(self) -> tuple[str, str]:
        """The names of engine and configuration."""
        return self.engine, self.configuration

    @property
    def who(self) -> str:
        """The names of engine and configuration in one text."""
        return " ".join(self.column)


@dataclass(frozen=True, eq=False)
class InspectedLink:
    """One link of a file, as the file states it and as engines hold it.

    Attributes
    ----------
    problems : faults of the numbers that the file states
    readings : how each configuration of each engine holds the link
    """

    link: Link
    problems: tuple[FileProblem, ...]
    readings: tuple[LinkReading, ...]

    @property
    def is_possible(self) -> bool:
        """Whether the numbers in the file are physically possible."""
        return not any(problem.impossible for problem in self.problems)

    @property
    def is_well(self) -> bool:
        """Whether the numbers in the file are possible and no engine's body differs from them."""
        return self.is_possible and all(reading.agrees is not False for reading in self.readings)


@dataclass(frozen=True, eq=False)
class Inspection:
    """The inspection of a whole file.

    Attributes
    ----------
    links : the file's links, with the bodies that engines hold
    refusals : why engines refuse the file, by the names of engine and configuration
    """

    model: ModelFile
    links: tuple[InspectedLink, ...]
    refusals: dict[tuple[str, str], str]

    @property
    def columns(self) -> list[tuple[str, str]]:
        """The names of engine and configuration by which the file was read, in pairs."""
        return [reading.column for reading in self.links[0].readings]

    @property
    def composed(self) -> list[RigidBody]:
        """The bodies of the file that consist of several links which are welded together."""
        return [body for body in rigid_bodies(self.model.links) if body.welded]

    @property
    def is_well(self) -> bool:
        """Whether no engine refuses the file, and all links are well (`InspectedLink.is_well`)."""
        return not self.refusals and all(link.is_well for link in self.links)


class CannotInspectError(Exception):
    """A model cannot be inspected: no such engine or version, or none that reads its format."""


@dataclass(frozen=True)
class ReaderEngine:
    """An engine that reads model files, at some version.

    Attributes
    ----------
    name : as users type it, for example "mujoco" or "mujoco@3.3.7"
    version : the engine's own version
    site : the folder that has this version; empty for the version installed in this environment
    reader : the engine's reader of model files
    """

    name: str
    version: str
    site: str
    reader: ModelReader


def reader_engines(
    names: Sequence[str] = (), say: Callable[[str], object] = len
) -> list[ReaderEngine]:
    """Return the engines with given names, which must read model files.

    A version of an engine, such as "mujoco@3.3.7", is installed first if necessary.

    Parameters
    ----------
    names : names as users type them; if empty, all readers of model files but optional ones
    say : called with a sentence before an installation

    Raises
    ------
    CannotInspectError
        If there is no such engine that reads model files, or no such version of it.
    """
    readers = model_readers()
    chosen = []
    usual = [name for name, reader in readers.items() if not reader.is_optional]
    for name in dict.fromkeys(names or usual):
        base, at, _ = name.partition("@")
        if base not in readers:
            raise CannotInspectError(
                f"'--engine' must be one of {', '.join(readers) or 'none'}, which read model "
                f"files, or a version of one, got '{name}'{did_you_mean(base, readers)}"
            )
        try:
            engine = versioned(name, say=say) if at else None
        except VersionError as error:
            raise CannotInspectError(f"'--engine' {error}") from None
        version, site = (engine.version, engine.site) if engine else (readers[base].version, "")
        chosen.append(ReaderEngine(name, version, site, readers[base]))
    return chosen


def inspect_model(
    model: ModelFile, executor: Executor, engines: Sequence[ReaderEngine]
) -> Inspection:
    """Return the inspection of a model, which is read by engines in all their configurations.

    Engines that cannot read the model's format are left out.

    Parameters
    ----------
    executor : calls the engines, which may crash or hang, in other processes

    Raises
    ------
    CannotInspectError
        If none of the engines reads the model's format.
    """
    able = [engine for engine in engines if model.format in engine.reader.formats]
    if not able:
        names = ", ".join(engine.name for engine in engines) or "no installed engine"
        raise CannotInspectError(f"{names} cannot read {model.format.upper()}")
    columns: list[list[LinkReading]] = []
    refusals: dict[tuple[str, str], str] = {}
    for engine in able:
        for one in engine.reader.configurations:
            who = (engine.name, engine.version, one.name)
            answer = executor.call_at(engine.site, read_held, engine.reader.name, model, one.name)
            if isinstance(answer.value, dict):
                columns.append(list(_compared(model, answer.value, who, one)))
                continue
            reason = answer.value.reason if isinstance(answer.value, CallFailed) else answer.value
            refusals[engine.name, one.name] = reason
            columns.append([LinkReading(*who, None, None, reason, "refused") for _ in model.links])
    readings = zip(*columns, strict=True)
    links = [
        InspectedLink(link, problems(link), row)
        for link, row in zip(model.links, readings, strict=True)
    ]
    return Inspection(model, tuple(links), refusals)


def read_held(engine: str, model: ModelFile, configuration: str) -> dict[str, BodyReading] | str:
    """Return the bodies that an engine has read from a file, by the names of the links.

    If the engine refuses the file, the reason is returned in words. This function is called in a
    worker process.

    Parameters
    ----------
    engine : name of the engine, without a version
    configuration : name of one of the engine's configurations
    """
    reader = model_readers().get(engine)
    if reader is None:
        return f"{engine} cannot be imported"
    try:
        return reader.read(model, configuration)
    except EngineError as error:
        return str(error)


def _compared(
    model: ModelFile,
    bodies: dict[str, BodyReading],
    who: tuple[str, str, str],
    configuration: Configuration,
) -> Iterator[LinkReading]:
    """Yield, for every link of the file, how one configuration of an engine holds it.

    Parameters
    ----------
    bodies : the engine's bodies, by the names of the links
    who : names of engine, version and configuration
    configuration : the engine's configuration
    """
    wholes = rigid_bodies(model.links, {link.name for link in model.links} - set(bodies))
    hosts = {part.name: body for body in wholes for part, _ in body.parts}
    for link in model.links:
        body = hosts.get(link.name)
        if link.name in bodies and body is not None:
            yield _link_reading(model, body, bodies[link.name], who, configuration)
            continue
        where = f"'{body.host.name}'" if body else "the world: it cannot move"
        yield LinkReading(*who, None, None, "" if link.name == WORLD else f"fused with {where}")


def _link_reading(
    model: ModelFile,
    whole: RigidBody,
    got: BodyReading,
    who: tuple[str, str, str],
    configuration: Configuration,
) -> LinkReading:
    """Return the comparison of an engine's body with the one that the file states.

    Parameters
    ----------
    whole : the link with those that the engine has fused with it, as the file states them
    got : the engine's body
    who : names of engine, version and configuration
    configuration : the engine's configuration
    """
    stated, others = whole.stated, tuple(link.name for link, _ in whole.parts[1:])
    if stated is None:
        empty = got.mass == 0 and not got.inertia_com.any()
        if model.format != "urdf":
            form = model.format.upper()
            words = "" if empty else f"taken from its shapes, as {form} has it"
            return LinkReading(*who, got, None, words)
        if empty:
            return LinkReading(*who, got, True, fused=others)
        return LinkReading(*who, got, False, unstated_body(got), "nothing stated", others)
    apart, kind, sentence = compared(stated, got, whole, configuration.made_up)
    if kind and whole.unread:
        return LinkReading(*who, got, None, whole.unread, "unread", others)
    if others and kind in ("other", "turned", "rotation lost"):
        kind, sentence = "sum", f"the sum of its fused parts is wrong: {sentence}"
    angles = attitude_apart(stated.inertia_com, got.inertia_com, np.array(TIMES))
    in_deg = None
    if angles is not None:
        in_deg = dict(zip(TIMES, np.degrees(angles).tolist(), strict=True))
    return LinkReading(*who, got, not kind, sentence, kind, others, stated, apart, in_deg)


def attitude_apart(stated: FloatArray, got: FloatArray, times: FloatArray) -> FloatArray | None:
    """Return the angles between the attitudes of two bodies that tumble freely, rad, (n,).

    Both start with attitude 1 and with the ω of components `START`, rad/s, along the principal axes
    of `stated`. An angle that rounding may cause is returned as zero.

    Parameters
    ----------
    stated, got : tensors of the bodies about the com, link's axes, (3, 3); multiplying one by a
        factor has no effect
    times : times of the angles, s, (n,), at most 3 s, the duration of the scene

    Returns
    -------
    The angles; None if a tensor is impossible, or a motion cannot be integrated
    """
    omega = np.linalg.eigh(stated)[1] @ START
    one, other = (_attitudes(tensor, omega, times) for tensor in (stated, got))
    if one is None or other is None:
        return None
    angles = (one.inv() * other).magnitude()
    return np.where(angles > ROUNDING, angles, 0.0)


def _attitudes(tensor: FloatArray, omega: FloatArray, times: FloatArray) -> Rotation | None:
    """Return the attitudes at n times of a body that tumbles freely and starts at the identity.

    None is returned if the tensor is impossible, or if the motion cannot be integrated.

    Parameters
    ----------
    tensor : tensor about the com, body axes, (3, 3); multiplying it by a factor has no effect
    omega : angular velocity at the start, body axes, rad/s, (3,)
    times : s, (n,)
    """
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    if not (total := float(moments.sum())) > 0:
        return None
    try:
        scene = loads(_SCENE.format((moments / total).tolist(), (omega @ axes).tolist()), "link")
        moved = solve_ode(scene, times)
    except (ValueError, IntegrationError):
        return None
    turn = Rotation.from_matrix(axes)
    return turn * moved.R_world_body * turn.inv()
