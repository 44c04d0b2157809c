"""Interfaces of engines that read users' model files, or simulate a link of such a file."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal

from ...scenarios import Scenario
from ..checks.read_back import BodyReading, Difference, EngineError, State, differences, stated_body
from ..engine import Engine
from .compare import AGREES, compared, radius_of_gyration
from .model_file import Format, ModelFile, Stated
from .read import users_link

#: Names of the differences that concern the body, as `read_back.differences` returns them.
OF_BODY = frozenset({"mass", "com", "inertia_com"})


@dataclass(frozen=True)
class Advice:
    """What users can do about a wrong body or a refused file, in an engine's own terms.

    Attributes
    ----------
    text : the advice as a sentence
    line : XML to be put into the file; empty if the advice is to do something else
    is_mended : whether newer versions of the engine no longer need the advice
    concerns : for a refused file, the links that the advice is about: "impossible" if their mass or
        tensor is, "massless" if they move and lack a mass or a tensor, "small" if their mass or a
        principal moment is below `least`. Empty for a wrong body
    least : the smallest mass, kg, and principal moment, kg m², that the engine takes
    """

    text: str
    line: str = ""
    is_mended: bool = False
    concerns: Literal["", "impossible", "massless", "small"] = ""
    least: float = 0.0


@dataclass(frozen=True)
class Configuration:
    """One of the ways in which users let an engine read a file.

    Attributes
    ----------
    name : as users type and read it
    summary : what is set, in one line
    made_up : where the tensors come from, in words; empty if the engine takes them from the file
    advice : what helps in this engine against a wrong body, by the word for its cause (see
        `compare.cause`), besides advice for all engines
    """

    name: str
    summary: str
    made_up: str = ""
    advice: Mapping[str, Advice] = field(default_factory=dict)


class ModelReader(ABC):
    """An engine's reader of model files.

    Attributes
    ----------
    name : as users type it
    formats : the formats of files that it reads
    configurations : the ways in which users let it read a file
    refusals : advice on how a refused file can be changed so that the engine accepts it. A key is a
        text that occurs in the engine's message. Its value has one piece of advice for each kind of
        link that may have caused the refusal (`Advice.concerns`)
    is_optional : whether the engine reads files only if the user names it
    """

    name: ClassVar[str]
    formats: ClassVar[frozenset[Format]]
    configurations: ClassVar[tuple[Configuration, ...]]
    refusals: ClassVar[Mapping[str, tuple[Advice, ...]]] = {}
    is_optional: ClassVar[bool] = False

    @property
    @abstractmethod
    def version(self) -> str:
        """The engine's own version."""

    @abstractmethod
    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Return the bodies that the engine has after it has read the file, by the links' names.

        A link that the engine has fused with another has no body of its own and is left out.

        Parameters
        ----------
        configuration : the name of one of `configurations`

        Raises
        ------
        EngineError
            If the engine refuses the file.
        """


class FileEngine(Engine):
    """An engine for scenes that name a link of a model file, and for no others.

    Bodies are compared with the tolerance of the command `inspect`, since some engines diagonalise
    tensors with larger errors than rounding.

    Attributes
    ----------
    reader : the engine's reader of whole files. A configuration of the reader that reads files as a
        method of the engine does has the method's name
    """

    interface = 1
    of_file = True
    slack = AGREES
    reader: ClassVar[ModelReader]

    @property
    def version(self) -> str:
        """The engine's own version, as its reader reports it."""
        return self.reader.version

    def applies_to(self, scenario: Scenario) -> bool:
        """Whether a scene names a link of a file in a format that the engine reads.

        It is also true if the file cannot be read, so that the run is made and fails.
        """
        if scenario.document.body.model is None:
            return False
        try:
            return users_link(scenario).model.format in self.reader.formats
        except EngineError:
            return True

    def differences(
        self, scenario: Scenario, method: str, body: BodyReading, state: State
    ) -> list[Difference]:
        """Return the differences of the engine's body and start from the scene's.

        `body` and `state` were read back before the first step of the method named `method`.
        Differences of mass, com and inertia are joined into one `Difference`, which is worded as by
        the command `inspect`.
        """
        # The com of symmetric parts is zero but for rounding.
        length = radius_of_gyration(stated_body(scenario))
        differing = differences(scenario, body, state, self.slack, length)
        others = [one for one in differing if one.what not in OF_BODY]
        if len(others) == len(differing):
            return differing
        # The body is compared with the scene's numbers; the file is needed only for the tensor
        # before the rotation of its frame.
        users, numbers = users_link(scenario), scenario.body
        unturned = users.stated.unturned
        stated = Stated(numbers.mass, numbers.com, numbers.inertia_com, unturned=unturned)
        made_up = {one.name: one.made_up for one in self.reader.configurations}.get(method, "")
        apart, _, words = compared(stated, body, users.body, made_up)
        if not words:
            return others
        found = _OtherBody("body", stated.inertia_com, body.inertia_com, apart.worst, words)
        return [found, *others]


@dataclass(frozen=True, eq=False)
class _OtherBody(Difference):
    """A difference between an engine's body and the body that the file states.

    Attributes
    ----------
    why : how and why they differ, in words
    """

    why: str

    @property
    def complaint(self) -> str:
        """The message of a run that fails because of this difference."""
        return f"holds another body than the file states: {self.why}"

    @property
    def remark(self) -> str:
        """The message of a run that goes on in spite of this difference."""
        return self.complaint
