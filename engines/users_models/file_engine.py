"""An engine that loads a link out of the user's own model file, instead of a generated model."""

from dataclasses import dataclass, replace
from functools import cache
from typing import ClassVar

from ...scenarios import Scenario
from ...scenarios.users_models import problems
from ..checks.read_back import BodyReading, Difference, EngineError, State
from ..discovery import engines
from ..engine import Engine
from .cause import cause
from .difference import AGREES, difference
from .model_reader import ModelReader
from .named_link import users_link

#: Names of a body's numbers in `read_back.differences`.
OF_BODY = frozenset({"mass", "com", "inertia_com"})


class FileEngine(Engine):
    """An engine for scenes that name a link of a model file, and for no others.

    Bodies are compared with the tolerance of `inspect`, as engines diagonalise tensors loosely.

    Attributes
    ----------
    reader : how the engine reads whole files; its configurations have the names of methods, if any
    """

    interface = 1
    of_file = True
    slack = AGREES
    reader: ClassVar[ModelReader]

    @property
    def version(self) -> str:
        """The engine's own version, as its reader has it."""
        return self.reader.version

    def applies_to(self, scenario: Scenario) -> bool:
        """Whether a scene names a link of a file in its formats; a missing file is a failed run."""
        if scenario.document.body.model is None:
            return False
        try:
            return users_link(scenario).model.format in self.reader.formats
        except EngineError:
            return True

    def differences(
        self, scenario: Scenario, method: str, body: BodyReading, state: State
    ) -> list[Difference]:
        """Differences from the scene; those of the body in the words of `inspect`."""
        differing = super().differences(scenario, method, body, state)
        others = [one for one in differing if one.what not in OF_BODY]
        if len(others) == len(differing):
            return differing
        users = users_link(scenario)
        # Compared with the scene's numbers; the file is needed for those without the rotation.
        numbers = scenario.body
        stated = replace(
            users.stated, mass=numbers.mass, com=numbers.com, inertia=numbers.inertia_com
        )
        apart = difference(stated, body)
        made_up = next(
            (one.made_up for one in self.reader.configurations if one.name == method), ""
        )
        wrong = tuple(problem for link, _ in users.body.parts for problem in problems(link))
        _, words = cause(stated, body, apart, wrong, made_up)
        other = _OtherBody("body", stated.inertia, body.inertia_com, apart.worst, words)
        return [other, *others]


@cache
def model_readers() -> dict[str, ModelReader]:
    """The readers of the engines that are installed, by name, sorted."""
    readers = [engine.reader for engine in engines().values() if isinstance(engine, FileEngine)]
    return {reader.name: reader for reader in readers}


@dataclass(frozen=True, eq=False)
class _OtherBody(Difference):
    """Another body than the file states, and why."""

    why: str

    @property
    def complaint(self) -> str:
        """The message of a run that fails because of it."""
        return f"holds another body than the file states: {self.why}"

    @property
    def remark(self) -> str:
        """The message of a run that goes on in spite of it."""
        return self.complaint
