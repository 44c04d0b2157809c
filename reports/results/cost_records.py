"""Measured times of a step."""

from dataclasses import dataclass

from .records import MethodKey, Record, Size, Variation, varied_in


@dataclass(frozen=True)
class Ratio:
    """The ratio of the times of a step of two engines that are timed in turn, round by round.

    Attributes
    ----------
    median, spread : median and interquartile range of the ratio over the rounds
    """

    median: Size
    spread: Size


@dataclass(frozen=True)
class StepCost:
    """The CPU and wall time of a step.

    Attributes
    ----------
    seconds_per_step : CPU seconds of all threads; the minimum over the repeats
    seconds_spread : maximum minus minimum over the repeats, CPU seconds
    wall_seconds_per_step : the minimum of the wall time; shorter than the CPU time only if threads
        share the work, longer if another program had the processor
    ratio : for a varied engine, its time over that of the engine as it is
    """

    seconds_per_step: Size
    seconds_spread: Size
    wall_seconds_per_step: Size
    ratio: Ratio | None = None


@dataclass(frozen=True)
class MethodCost(Record):
    """The cost of a step of a method on a scene, on one processor.

    Attributes
    ----------
    cost : None if the steps cannot be timed
    variation : JSON that says how the engine is varied; empty if it is not
    difference : the largest difference of any number of the state between the engine that leaves
        nothing out and the engine as it is by default, SI; 0 if the motions are identical
    compared_until : time up to which the two motions were compared, s; the end of the window unless
        one of them diverged
    """

    key: MethodKey
    processor: str
    cost: StepCost | None
    variation: Variation = ""
    difference: Size | None = None
    compared_until: Size | None = None

    @property
    def left_in(self) -> tuple[str, ...]:
        """The names of what this engine did that it leaves out by default."""
        return tuple(varied_in(self.variation).get("left_in", ()))
