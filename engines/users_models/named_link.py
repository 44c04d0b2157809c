"""Reads the link of a user's model that a scene names."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from ...scenarios import Scenario
from ...scenarios.users_models import (
    IDENTITY,
    ModelFile,
    ModelFileError,
    RigidBody,
    Stated,
    read_model,
    rigid_bodies,
)
from ..checks.read_back import EngineError, UnsupportedError

#: Number of files kept: all runs of a ladder need the same one.
KEPT = 16


@dataclass(frozen=True, eq=False)
class UsersLink:
    """A link with what is welded to it, and its file.

    Attributes
    ----------
    body : only those welded links that the scene names
    stated : mass, com and tensor of the whole
    """

    model: ModelFile
    body: RigidBody
    stated: Stated


def users_link(scenario: Scenario) -> UsersLink:
    """The link that a scene names.

    Raises
    ------
    UnsupportedError
        If it names none, or the scene has no file, to which the model's path is relative.
    EngineError
        If the file cannot be read, is not the one that the scene was made of, or has no such link.
    """
    body = scenario.document.body
    if body.model is None or body.link is None or body.sha256 is None or scenario.path is None:
        raise UnsupportedError("the scene names no link of a model file", "effects")
    try:
        model = _read(scenario.path.absolute().parent / body.model, body.sha256)
    except ModelFileError as error:
        raise EngineError(str(error), "refused") from None
    if sha256(model.data).hexdigest() != body.sha256:
        raise EngineError(f"'{body.model}' has changed since the scene was made of it", "refused")
    whole = _rigid_body(model, body.link, body.model)
    if unknown := sorted({*(body.welded or ())} - {*whole.welded}):
        raise EngineError(
            f"in '{body.model}' no link '{unknown[0]}' with an inertia is welded to '{body.link}'",
            "refused",
        )
    whole = whole.only(body.welded or ())
    if whole.stated is None:
        raise EngineError(f"'{body.model}' states no inertia of '{body.link}'", "refused")
    return UsersLink(model, whole, whole.stated)


def _rigid_body(model: ModelFile, link: str, file: str) -> RigidBody:
    """The body of that link, with all that is welded to it."""
    try:
        alone = model.link(link)
    except KeyError:
        raise EngineError(f"'{file}' has no link '{link}'", "refused") from None
    hosted = [body for body in rigid_bodies(model.links) if body.host is alone]
    return hosted[0] if hosted else RigidBody(((alone, IDENTITY),))


@lru_cache(maxsize=KEPT)
def _read(path: Path, digest: str) -> ModelFile:  # noqa: ARG001
    """The file; cached by its digest."""
    return read_model(path)
