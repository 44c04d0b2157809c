"""Measured times: of a step, and of what is left out."""

from dataclasses import dataclass

from .records import Key


@dataclass(frozen=True)
class StepCost:
    """What a step costs.

    Attributes
    ----------
    seconds_per_step : CPU seconds, of all threads: the least over the repeats
    spread : the largest of them less the least
    wall_seconds_per_step : the least by the clock on the wall: shorter only if threads share the
        work, longer where something else had the processor
    """

    seconds_per_step: float
    spread: float
    wall_seconds_per_step: float


@dataclass(frozen=True)
class Ratio:
    """How one time a step compares with another: of rounds timed in turn, the ratios' median.

    Attributes
    ----------
    spread : distance of the quartiles
    """

    median: float
    spread: float


@dataclass(frozen=True)
class EffectsCost:
    """A method on a scene, pruned to what the scene calls for, against what it is by default.

    Attributes
    ----------
    left_out : what is pruned, by the engine's own names
    pruned, unpruned : CPU seconds a step, the least over the rounds
    ratio : unpruned over pruned
    timestep : s, at which the motions were compared
    compared_until : s; the whole window, unless one of the two diverged
    difference : the largest of any number read, in its SI unit; 0 if identical to the last bit
    """

    key: Key
    left_out: tuple[str, ...]
    pruned: float
    unpruned: float
    ratio: Ratio
    timestep: float
    compared_until: float
    difference: float

    @property
    def sentence(self) -> str:
        """What to say of it."""
        return f"{(self.ratio.median - 1):+.0%} a step; {self.same_motion}"

    @property
    def same_motion(self) -> str:
        """Whether leaving things out changed the motion."""
        if self.difference == 0:
            return "the motion is identical to the last bit"
        return f"the motion differs by {self.difference:.1e}"


@dataclass(frozen=True)
class PassCost:
    """What one pass costs, as a part of the time of a pruned step.

    Attributes
    ----------
    added : by leaving in nothing else
    saved : by leaving it out of everything else that the engine does by default
    """

    name: str
    added: float
    saved: float


@dataclass(frozen=True)
class PassCosts:
    """What each pass left out costs a method on a scene, one by one.

    Attributes
    ----------
    pruned : CPU seconds a step with none of them
    noise : what equal sessions differ by, in the same units as `added` and `saved`
    """

    key: Key
    pruned: float
    noise: float
    passes: tuple[PassCost, ...]
