"""The methods of an engine, and those of its other versions."""

from dataclasses import dataclass

import numpy as np

from ..scenarios import Distance

#: Effects that all engines of jointed rigid bodies can simulate. Scenes can have further effects; a
#: method states those of them that it can simulate as well.
COMMON_EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})


@dataclass(frozen=True)
class Method:
    """One of an engine's integrators or formulations, by which it can simulate a scene.

    Attributes
    ----------
    name : name of the method, as users type it
    order : declared order of accuracy of ω
    attitude_order : declared order of accuracy of the attitude
    summary : one line for tables
    effects : names, out of `scenarios.EFFECTS`, of the effects that the method can simulate
    requires : names of the effects that a scene must have for the method to be applicable, such as
        a pivot for a method that simulates pivots by a constraint
    max_rotation_per_step : the largest rotation in a step, rad, that the engine does not silently
        clamp; a run in which the body turns further in a step is not made, or ends there
    clamps_parts : whether the engine also clamps how far rotors turn in a step
    as_shipped : whether the engine runs with all its defaults: a difference from the scene is then
        a remark, and does not fail a run
    reader : whether the method differs from one of another engine only in how models are read
    setup : code by which users of the engine choose the method, with `TIMESTEP` for the timestep in
        s; empty if it takes more than a few lines
    """

    name: str
    order: int
    attitude_order: int
    summary: str
    effects: frozenset[str]
    requires: frozenset[str] = frozenset()
    max_rotation_per_step: Distance = np.inf
    clamps_parts: bool = False
    as_shipped: bool = False
    reader: bool = False
    setup: str = ""

    @property
    def is_recommendable(self) -> bool:
        """Whether reports may recommend the method: it is neither as shipped nor a `reader`."""
        return not (self.as_shipped or self.reader)


@dataclass(frozen=True)
class Release:
    """One version of an engine.

    Attributes
    ----------
    requirements : distributions to install, as pip takes them. Under the running Python they are
        installed without dependencies: list a dependency here if this version needs another release
        of it than the newest version of the engine does
    methods : the methods, with their orders in this version
    installed_as : name of the engine under which the version is installed, if two engines share a
        package; empty if that is the engine's own name
    surplus : packages that are removed after pip has installed them, since no run imports them
    """

    requirements: tuple[str, ...]
    methods: tuple[Method, ...]
    installed_as: str = ""
    surplus: tuple[str, ...] = ()
