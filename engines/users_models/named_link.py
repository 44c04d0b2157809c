"""Reads the link of a user's model that a scene names."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from ...scenarios import Scenario
from ...scenarios.users_models import Link, ModelFile, ModelFileError, read_model
from ..checks.read_back import EngineError, UnsupportedError

#: Number of files kept: all runs of a ladder need the same one.
KEPT = 16


@dataclass(frozen=True, eq=False)
class UsersLink:
    """A link, and its file."""

    model: ModelFile
    link: Link


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
    try:
        link = model.link(body.link)
    except KeyError:
        raise EngineError(f"'{body.model}' has no link '{body.link}'", "refused") from None
    if link.stated is None:
        raise EngineError(f"'{body.model}' states no inertia of '{body.link}'", "refused")
    return UsersLink(model, link)


@lru_cache(maxsize=KEPT)
def _read(path: Path, digest: str) -> ModelFile:  # noqa: ARG001
    """The file; cached by its digest."""
    return read_model(path)
