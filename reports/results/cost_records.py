"""Measured times: of a step, and of what is left out."""

from dataclasses import dataclass

from .records import MethodKey, Record, Size


@dataclass(frozen=True)
class StepCost:
    """What a step costs.

    Attributes
    ----------
    seconds_per_step : CPU seconds of all threads; the minimum over the repeats
    seconds_spread : maximum minus minimum over the repeats, CPU seconds
    wall_seconds_per_step : the minimum of the wall time; shorter than the CPU time only if threads
        share the work, longer if another program had the processor
    instructions_per_step : None unless they were counted (`harness/instructions.py`)
    """

    seconds_per_step: Size
    seconds_spread: Size
    wall_seconds_per_step: Size
    instructions_per_step: Size | None = None


@dataclass(frozen=True)
class MethodCost(Record):
    """The cost of a step of a method on a scene, on one processor; None if it cannot be timed."""

    key: MethodKey
    processor: str
    cost: StepCost | None


@dataclass(frozen=True)
class Ratio:
    """The ratio of two times a step: the median over rounds timed in turn.

    Attributes
    ----------
    spread : interquartile range
    """

    median: Size
    spread: Size


@dataclass(frozen=True)
class EffectsCost(Record):
    """A method on a scene, pruned to what the scene calls for, against what it is by default.

    Attributes
    ----------
    left_out : what is pruned, by the engine's own names
    pruned, unpruned : CPU seconds a step, the minimum over the rounds
    ratio : unpruned over pruned
    timestep : s, at which the motions were compared
    compared_until : s; the whole window, unless one of the two diverged
    difference : the largest difference of any number read, in its SI unit; 0 if identical
    """

    key: MethodKey
    left_out: tuple[str, ...]
    pruned: Size
    unpruned: Size
    ratio: Ratio
    timestep: Size
    compared_until: Size
    difference: Size

    @property
    def sentence(self) -> str:
        """The result in words, for reports."""
        return f"{(self.ratio.median - 1):+.0%} a step; {self.same_motion}"

    @property
    def same_motion(self) -> str:
        """The answer whether leaving things out changed the motion, in words."""
        if self.difference == 0:
            return "the motion is identical to the last bit"
        return f"the motion differs by {self.difference:.1e}"


@dataclass(frozen=True)
class PassCost:
    """What one pass costs, as a part of the time of a pruned step.

    Attributes
    ----------
    added : when it alone is left in
    saved : when it alone is left out, and all other passes are left in
    """

    name: str
    added: float
    saved: float


@dataclass(frozen=True)
class PassCosts(Record):
    """What each pass left out costs a method on a scene, one by one.

    Attributes
    ----------
    pruned : CPU seconds a step with none of them
    noise : by how much equal sessions differ, in the unit of `added` and `saved`
    """

    key: MethodKey
    pruned: Size
    noise: Size
    passes: tuple[PassCost, ...]
