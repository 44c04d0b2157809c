"""What an engine can simulate with: its methods, and those of its other versions."""

from dataclasses import dataclass

import numpy as np

from ..scenarios import Distance

#: Effects that engines of jointed rigid bodies can simulate, which are not all that a scene can
#: call for. A method that can simulate a further effect adds it.
COMMON_EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})


@dataclass(frozen=True)
class Method:
    """One of an engine's integrators or formulations, by which it can simulate a scene.

    Attributes
    ----------
    name : as users type it
    order : order of accuracy of ω in the timestep, as the adapter declares it
    attitude_order : order of accuracy of the attitude, likewise
    summary : one line for tables
    effects : names, out of `scenarios.EFFECTS`, of the effects that it can simulate
    requires : names of the effects that a scene must have for the method to be applicable, such as
        a pivot for a method that simulates pivots by a constraint
    max_rotation_per_step : rad; the engine silently clamps larger rotations, so that a run in which
        the body turns further in a step is not made, or ends there
    clamps_parts : whether the engine also clamps how far parts of the body turn relative to it
    as_shipped : whether the engine runs with all its defaults: a difference from the scene is then
        a remark, and does not fail a run
    reader : whether it differs from a method of another engine only in how models are read
    setup : what users of the engine write to use the method, with `TIMESTEP` for the timestep in s;
        empty if it takes more than a few lines
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
        """Whether reports may recommend the method: it is neither as shipped nor just a reader."""
        return not (self.as_shipped or self.reader)


@dataclass(frozen=True)
class Release:
    """One version of an engine.

    Attributes
    ----------
    requirements : distributions to install, as pip takes them. Their dependencies are not installed
        with them; a dependency is listed if this version needs another release of it than the
        newest version of the engine does
    methods : the methods, with their orders in that version
    installed_as : name of the engine whose installed versions this one shares; empty for none
    surplus : packages that pip installs with it and that no run imports, which are removed
    """

    requirements: tuple[str, ...]
    methods: tuple[Method, ...]
    installed_as: str = ""
    surplus: tuple[str, ...] = ()
