"""The interface by which engines read users' model files."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...scenarios.users_models import Format, ModelFile
from ..checks.read_back import BodyReading
from .cause import Kind


@dataclass(frozen=True)
class Configuration:
    """One way in which users have an engine read a file.

    Attributes
    ----------
    name : as users type and read it
    summary : what is set, in one line
    made_up : the source of tensors that are not taken from the file; else empty
    remedy : what to do if it holds another tensor than the file's; empty if nothing is known
    """

    name: str
    summary: str
    made_up: str = ""
    remedy: str = ""


@dataclass(frozen=True)
class Advice:
    """What to do in an engine's own terms.

    Attributes
    ----------
    line : of XML to put into the file; empty where the advice is something else
    is_mended : whether a newer version needs it no longer
    """

    text: str
    line: str = ""
    is_mended: bool = False


@dataclass(frozen=True)
class RefusalAdvice:
    """What makes an engine take a file that it refuses.

    Attributes
    ----------
    phrases : any of them in the engine's reason tells this refusal
    concerns : links with a tensor that no body has, or those that move without mass or tensor
    """

    phrases: tuple[str, ...]
    concerns: Literal["impossible", "massless"]
    advice: Advice


class ModelReader(ABC):
    """An engine's reader of model files.

    Attributes
    ----------
    advice : by what it has done to a link: what mends it, or has to be known besides
    refusals : those with known advice
    """

    name: ClassVar[str]
    formats: ClassVar[frozenset[Format]]
    configurations: ClassVar[tuple[Configuration, ...]]
    advice: ClassVar[Mapping[Kind, Advice]] = {}
    refusals: ClassVar[tuple[RefusalAdvice, ...]] = ()

    @property
    @abstractmethod
    def version(self) -> str:
        """The engine's own version."""

    @abstractmethod
    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """The bodies that the engine has after it has read the file, by the links' names.

        A link that was fused with another has no body and is left out.

        Raises
        ------
        EngineError
            If it refuses the file.
        """
