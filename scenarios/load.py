"""Reads scenario files; every complaint names file, line, table, key, value and rule."""

import re
import sys
import tomllib
from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from .complaints import MAX_SHOWN, at, misfit, validation_message
from .document import Document
from .errors import Misfit, ScenarioError, printable
from .read_text import first_key, is_nested_too_deeply, read_text
from .regular_files import LARGEST_MODEL, read_regular
from .scales import check_scales
from .scenario import Scenario, build
from .signals import SIGNAL
from .write import to_toml

MARKER = "spincheck"
#: Largest length of a scene's name, bytes. A file's name has 255 at most, and that of a file named
#: after the scene has an ending, and perhaps a number, besides.
LONGEST_NAME = 200
#: Matches an integer of more digits than Python converts.
_MANY_DIGITS = re.compile(rf"[0-9_]{{{sys.get_int_max_str_digits()}}}")
#: Matches the line number in a message of the TOML parser.
_PARSER_LINE = re.compile(r"\(at line (\d+), column \d+\)$")


def load(path: str | Path) -> Scenario:
    """Return the scenario that a file describes.

    Raises
    ------
    ScenarioError
        If the file cannot be read, is not TOML, or breaks a rule of the format.
    """
    path = Path(path)
    return loads(read_text(path), name=path.stem, path=path)


def load_each(paths: Iterable[str | Path]) -> tuple[list[Scenario], list[str]]:
    """Return the scenarios of all valid files, and a message for each invalid one."""
    scenarios, wrong = [], []
    for path in paths:
        try:
            scenarios.append(load(path))
        except ScenarioError as error:
            wrong.append(str(error))
    return scenarios, wrong


def loads(text: str, name: str, path: Path | None = None) -> Scenario:
    """Return the scenario that the text of a scenario file describes.

    Parameters
    ----------
    name : name of the scene, for which `load` takes the file's stem
    path : the file, for messages and for paths in it; None without a file

    Raises
    ------
    ScenarioError
        If the name is not one of a scene, or the text is not TOML or breaks a rule of the format.
    """
    where = printable(str(path or name))
    if not is_scene_name(name):
        raise ScenarioError(
            f"{where}: a scenario's name is its file's stem; use letters, digits, '-', '_', '.', "
            f"{LONGEST_NAME} bytes at most"
        )
    try:
        return _scenario(_parsed(text, where), name, text, path)
    except RecursionError:
        raise ScenarioError(f"{where}: not valid TOML: nested too deeply") from None
    except ValidationError as error:
        raise ScenarioError(validation_message(error.errors(), text, where)) from None
    except Misfit as error:
        raise ScenarioError(misfit(error, text, where)) from None


def from_tables(tables: Mapping[str, Any], name: str = "scene") -> Scenario:
    """Return the scenario that TOML tables describe, as if they had been read from its file.

    Parameters
    ----------
    tables : the tables as `tomllib` returns them; NumPy's arrays and numbers may replace lists and
        numbers, and `spincheck = 1` may be missing
    name : name of the scene

    Raises
    ------
    ScenarioError
        If the tables break a rule of the format.
    """
    return loads(to_toml({MARKER: 1, **_plain(tables)}), name)


def _plain(value: Any) -> Any:
    """Return a value with NumPy's arrays and numbers in it replaced by lists and numbers."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def is_scene_name(name: str) -> bool:
    """Whether a scene's name is safe for the files and pages that are named after the scene."""
    short = len(name.encode(errors="replace")) <= LONGEST_NAME
    return short and name[:1].isalnum() and all(c.isalnum() or c in "-_." for c in name)


def _parsed(text: str, where: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Parameters
    ----------
    where : name of the file, for messages

    Raises
    ------
    ScenarioError
        If it is not TOML, or its first key does not mark it as a scenario.
    RecursionError
        If it is nested too deeply.
    """
    if is_nested_too_deeply(text):
        raise RecursionError
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = printable(str(error), MAX_SHOWN)
        match = _PARSER_LINE.search(str(error))
        # An error at the end of the text names no line.
        last = int(match[1]) if match else len(text.splitlines())
        raise ScenarioError(at(where, last, f"not valid TOML: {message}")) from None
    except ValueError:
        # The parser hit Python's own limit on the digits of an integer.
        match = _MANY_DIGITS.search(text)
        line = text.count("\n", 0, match.start()) + 1 if match else None
        raise ScenarioError(at(where, line, "not valid TOML: an integer is too large")) from None
    if next(iter(tables), None) != MARKER:
        raise ScenarioError(f"{where}: not a scenario: the first key must be 'spincheck = 1'")
    return tables


def _scenario(tables: dict[str, Any], name: str, text: str, path: Path | None) -> Scenario:
    """Return the scenario of parsed tables, after all checks of tables and of their consistency.

    Parameters
    ----------
    name : name of the scene
    text : the text that the tables were parsed from
    path : the file, which paths in the tables are relative to; None without a file

    Raises
    ------
    ValidationError, Misfit
        If the tables break a rule of the format.
    """
    scenario = build(Document.model_validate(tables), name=name, text=text, path=path)
    check_scales(scenario)
    for k, expected in enumerate(scenario.document.expect):
        for name in expected.bounds():
            if not SIGNAL[name].exists(scenario):
                raise Misfit(f"the scene has no {SIGNAL[name].quantity}", "expect", k, name)
    for effect in scenario.acting:
        effect.check(scenario, scenario.document.start)
    _check_origin(scenario)
    return scenario


def _check_origin(scenario: Scenario) -> None:
    """Check that the file that `[body] model` names has the digest in `[body] sha256`.

    Nothing is checked for a scene without a file, as it has no folder that the name is relative to.

    Raises
    ------
    Misfit
        If the file cannot be read, or has another digest.
    """
    body = scenario.document.body
    if body.model is None or scenario.path is None:
        return
    path = scenario.path.parent / body.model
    try:
        digest = sha256(read_regular(path, LARGEST_MODEL)).hexdigest()
    except OSError as error:
        where = printable(str(path))
        raise Misfit(f"{where}: cannot be read: {error.strerror}", "body", "model") from None
    if digest != body.sha256:
        raise Misfit(
            f"'{body.model}' has changed since this scene was made of it; import it again, or take "
            "'model', 'link' and 'sha256' away",
            *("body", "sha256"),
        )


def is_scenario(path: Path) -> bool:
    """Whether a TOML file's first key is `spincheck`, without judging the rest of it."""
    return first_key(path) == MARKER
