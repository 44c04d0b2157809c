"""Records of a result file: solved scenes, and one row for each run.

A record's fields are stored (`tables`) and shown as JSON and CSV (`as_json`). A new field is added
here alone; it needs a default, which records get that were stored before the field was added.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, ConfigDict

from ...engines import Cause, Outcome
from ...reference import Solution
from ...scenarios import (
    Distance,
    Errors,
    Scenario,
    SignalName,
    Trajectory,
    is_scene_name,
    loads,
    printable,
)

#: Names of an engine and of one of its methods.
Pair = tuple[str, str]
#: Timestep, s, of the only row of a method on a scene whose exact motion could not be solved.
UNSOLVED = 0.0
#: Names of the fields of records that hold a motion.
MOTIONS = ("motion", "trajectory")
#: Largest absolute value of a finite number in a record: its square does not overflow.
LARGEST = 1e150


def _size(value: float) -> float:
    """Return a number from 0 to `LARGEST`, or inf; raise `ValueError` for any other number."""
    if not 0 <= value <= LARGEST and value != math.inf:
        raise ValueError(f"must be from 0 to {LARGEST:g}")
    return value


def _finite(value: float) -> float:
    """Return a number; raise `ValueError` if it is NaN or larger in size than `LARGEST`."""
    if not abs(value) <= LARGEST:
        raise ValueError(f"must be from -{LARGEST:g} to {LARGEST:g}")
    return value


def _name_of_scene(name: str) -> str:
    """Return a scene's name; raise `ValueError` if it is invalid: a page's file gets this name."""
    if not is_scene_name(name):
        raise ValueError(f"{printable(name)!r} is no scene's name")
    return name


def _name(name: str) -> str:
    """Return the name of an engine or method; raise `ValueError` if it is empty."""
    if not name:
        raise ValueError("names no engine or no method")
    return name


def variation(varied: Mapping[str, Any]) -> str:
    """Return the JSON text that identifies what is varied in a run; empty if nothing is.

    Parameters
    ----------
    varied : what is varied, by name, such as the seed and the member of an ensemble
    """
    return json.dumps(varied, sort_keys=True) if varied else ""


def varied_in(text: str) -> dict[str, Any]:
    """Return what is varied in a run, by name, from the text that `variation` has made of it."""
    return json.loads(text) if text else {}


def _variation(text: str) -> str:
    """Return a text; raise `ValueError` unless it is one that `variation` can return."""
    if text and (not isinstance(varied := json.loads(text), dict) or variation(varied) != text):
        raise ValueError(f"{printable(text)!r} says of nothing that it is varied")
    return text


#: Types of fields that are checked when a record is read, as a file may come from anyone.
Size = Annotated[float, AfterValidator(_size)]
Count = Annotated[int, AfterValidator(_size)]
Signed = Annotated[float, AfterValidator(_finite)]
SceneName = Annotated[str, AfterValidator(_name_of_scene)]
Name = Annotated[str, AfterValidator(_name)]
Variation = Annotated[str, AfterValidator(_variation)]


@dataclass(frozen=True, eq=False)
class Record:
    """Base of dataclasses that are stored in result files.

    A value of another type than its field declares is refused when a record is read from a file,
    and so is an unknown field. The constructor does not check types.
    """

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid", arbitrary_types_allowed=True)


class OfMethod:
    """Base of classes that name an engine and one of its methods."""

    engine: str
    method: str

    @property
    def pair(self) -> Pair:
        """The names of engine and method."""
        return self.engine, self.method

    @property
    def label(self) -> str:
        """Engine and method in one text, as users type them."""
        return f"{self.engine} {self.method}"


@dataclass(frozen=True)
class Key(OfMethod):
    """The names of scene, engine and method, which identify the results of a method on a scene."""

    scenario: SceneName
    engine: str
    method: str


def _named(key: Key) -> Key:
    """Return a key; raise `ValueError` if it names no engine or no method."""
    _name(key.engine)
    _name(key.method)
    return key


#: A `Key` whose names of engine and method are checked when a record is read.
MethodKey = Annotated[Key, AfterValidator(_named)]


@dataclass(frozen=True)
class Defect:
    """The defects of a run in one signal.

    A defect is what a run does from one sample to the next, less what the exact motion does from
    the same sample.

    Attributes
    ----------
    p50, p95, max : median, 95th percentile and largest over the intervals between samples, in the
        norm and unit of the signal's errors
    at : time of the end of the interval with the largest defect, s
    floor : the largest defect that rounding and the tolerance of solvers may cause
    """

    p50: Size
    p95: Size
    max: Size
    at: Size
    floor: Size


@dataclass(frozen=True, eq=False)
class SolvedScene(Record):
    """A scene's file and its exact motion at the sample times.

    Attributes
    ----------
    scenario : the scene's name
    toml : the text of the scene's file
    method : how the motion was solved, in words
    uncertainty, conditioning : of the exact motion, in each signal
    horizon : time from which the motion is not known, s; None if it is known throughout
    lifts_off : whether the motion ends because the body leaves its table
    trajectory : the motion; None if it is missing
    """

    scenario: SceneName
    toml: str
    method: str
    uncertainty: Errors
    conditioning: Errors
    horizon: Size | None = None
    lifts_off: bool = False
    trajectory: Trajectory | None = None

    @staticmethod
    def of(scenario: Scenario, solution: Solution) -> "SolvedScene":
        """Return the record of a scene and its exact motion."""
        return SolvedScene(scenario.name, scenario.text, **vars(solution))

    def solved(self) -> tuple[Scenario, Solution]:
        """Return the scene and its exact motion.

        Raises
        ------
        ValueError
            If the file is not a valid scene, or the motion is missing.
        """
        if self.trajectory is None:
            raise ValueError("a scene without its exact motion")
        names = (field.name for field in fields(Solution))
        solution = Solution(**{name: getattr(self, name) for name in names})
        return loads(self.toml, self.scenario), solution


@dataclass(frozen=True, eq=False)
class Row(Record):
    """One run, compared with the exact motion.

    Attributes
    ----------
    key : names of scene, engine and method
    timestep : s
    variation : JSON of what is varied, such as the member of an ensemble; empty if nothing is
    reason : why the outcome is not ok; for an engine as shipped, what differs from the scene
    cause : the cause in one word; empty if there is none
    without_skill : whether a run that is ok is no better than no motion
        (`harness/comparison/rows.py`)
    stopped_at : time at which the run diverged or failed, s; None if it did not, or if unknown
    errors : errors at the run's sample times; None unless the outcome is ok
    drifts : largest change of each conserved quantity, relative, by name
    reference_uncertainty : relative uncertainty of the exact motion, in ω
    steps : number of steps up to the run's last sample
    seconds_per_step, seconds_spread : CPU seconds of a step, the least over the repeats, and
        max − min over the repeats; None if not timed
    wall_seconds_per_step : the least wall time of a step, s; None if not timed
    motion : the samples; None if there are none, or if they were not kept
    printed : what the engine wrote to stdout and stderr
    stock : whether the timestep is one of the two at which an engine is run on every scene: its own
        stock timestep, or 1 ms
    unasked : for an engine as shipped, the engine's names of what acted although the scene does not
        call for it
    defects : defects by signal (`harness/comparison/defects.py`), at stock timesteps and those that
        a user asks for; None at others, or if they cannot be computed
    turns : turns of the exact motion over the samples, 2π rad each
    turns_within_1deg : turns until the attitude is off by more than 1°; None if it never is
    attitude_a_turn : median over the intervals between samples of the attitude's defect per turn,
        rad; None if there are no defects or the run is always at rest
    acts : for a run that keeps at most one default of the engine, whether single steps show a
        fault, and so do not obey the equations of motion however short they are; None if unknown
    """

    key: MethodKey
    engine_version: str
    timestep: Size
    outcome: Outcome
    reason: str = ""
    cause: Cause = ""
    stopped_at: Size | None = None
    errors: Errors | None = None
    drifts: dict[str, Distance] | None = None
    reference_uncertainty: Size = 0.0
    steps: Count = 0
    seconds_per_step: Size | None = None
    seconds_spread: Size | None = None
    wall_seconds_per_step: Size | None = None
    motion: Trajectory | None = None
    printed: str = ""
    without_skill: bool = False
    stock: bool = False
    unasked: tuple[str, ...] = ()
    defects: dict[SignalName, Defect] | None = None
    turns: Size | None = None
    turns_within_1deg: Size | None = None
    attitude_a_turn: Size | None = None
    acts: bool | None = None
    variation: Variation = ""

    def __post_init__(self) -> None:
        if self.errors is not None and self.outcome != "ok":
            raise ValueError(f"a run that is not ok has no errors: {self.outcome}, {self.key}")

    @property
    def varied(self) -> dict[str, Any]:
        """What is varied in the run, by name: seed and member of an ensemble, or kept defaults."""
        return varied_in(self.variation)

    @property
    def pair(self) -> Pair:
        """The names of engine and method."""
        return self.key.pair

    @property
    def made(self) -> bool:
        """Whether the run was made, and not refused because of its timestep."""
        return self.cause != "timestep"

    @property
    def simulated(self) -> bool:
        """Whether the engine can simulate the scene with this timestep; the run may have failed."""
        return self.outcome != "unsupported"

    @property
    def ending_in_words(self) -> str:
        """Why and when the run ended as it did, and its timestep, in words.

        If the engine cannot simulate one of the scene's effects, only the reason is given.
        """
        when = f" at {self.stopped_at:.4g} s" if self.stopped_at is not None else ""
        if self.cause == "effects":
            return self.reason
        if not self.simulated:
            return f"{self.reason} (at a timestep of {self.timestep:.3g} s)"
        return f"{self.reason}{when}, with a timestep of {self.timestep:.3g} s"

    @property
    def survived(self) -> bool:
        """Whether the outcome is `ok` and the run is better than no motion."""
        return self.outcome == "ok" and not self.without_skill
