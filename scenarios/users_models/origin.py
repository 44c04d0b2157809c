"""The user's model that a scene's numbers are from: it must be the file it was."""

import hashlib
from pathlib import Path

from ..errors import Misfit
from ..scenario import Scenario
from .errors import ModelFileError
from .xml_tree import read_bytes


def check_origin(scenario: Scenario) -> None:
    """Compare the file that `[body] model` names with the digest beside it.

    A scene without a file of its own has no folder that the name could be relative to.

    Raises
    ------
    Misfit
        If the file cannot be read, or is another one.
    """
    body = scenario.document.body
    if body.model is None or scenario.path is None:
        return
    try:
        sha256 = digest(scenario.path.parent / body.model)
    except ModelFileError as error:
        raise Misfit(str(error), "body", "model") from None
    if sha256 != body.sha256:
        raise Misfit(
            f"'{body.model}' has changed since this scene was made of it: its sha256 is {sha256}; "
            "import it again, or take 'model', 'link' and 'sha256' away",
            *("body", "sha256"),
        )


def digest(path: Path) -> str:
    """SHA-256 of a model file, hexadecimal.

    Raises
    ------
    ModelFileError
        If it cannot be read.
    """
    return hashlib.sha256(read_bytes(path)).hexdigest()
