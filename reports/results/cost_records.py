"""Records of the measured cost of a step."""

from dataclasses import dataclass

from .records import MethodKey, Record, Size, Variation, varied_in


@dataclass(frozen=True)
class Ratio:
    """The CPU time of a step of a varied engine, divided by that of the unvaried engine.

    Attributes
    ----------
    median, spread : median and interquartile range of the ratio, over rounds in each of which both
        engines are timed once
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
    wall_seconds_per_step : the minimum of the wall time, s; it is shorter than the CPU time only if
        threads share the work, and longer if another program used the processor
    ratio : for a varied engine, its CPU time over that of the unvaried engine; else None
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
    processor : name of the processor
    cost : None if the steps cannot be timed
    variation : JSON that says how the engine is varied, for example which parts of a step it makes
        that it leaves out by default; empty if the engine is not varied
    difference : for an engine that is varied to leave nothing out, the largest difference of any
        component of its state from that of the unvaried engine, SI; 0 if the motions are identical;
        None if they were not compared
    compared_until : time up to which the two motions were compared, s; the end of the window unless
        an engine failed before. None if they were not compared
    """

    key: MethodKey
    processor: str
    cost: StepCost | None
    variation: Variation = ""
    difference: Size | None = None
    compared_until: Size | None = None

    @property
    def left_in(self) -> tuple[str, ...]:
        """The names of the passes (parts of a step) that were switched on for this measurement.

        By default the adapter leaves them out, as the scene does not call for them. The tuple is
        empty if nothing was switched on.
        """
        return tuple(varied_in(self.variation).get("left_in", ()))
