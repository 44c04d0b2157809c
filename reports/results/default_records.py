"""The effect of each of an engine's defaults on the motion of a scene, from runs with and without.

A default is something that the engine does to motions unless it is told not to.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ...scenarios import Errors
from .records import Key, Row

#: Name of the entry in a run's variation that lists the names of the defaults that are kept.
DEFAULTS = "defaults"


@dataclass(frozen=True)
class DefaultEffect:
    """The effect of one default of a method as shipped.

    A default is something that the engine does to motions unless it is told not to, such as
    damping.

    Attributes
    ----------
    name : the engine's own name for the default
    alone : errors with this default and no other; None if the run did not finish
    without : errors with all defaults but this one; None if the run did not finish
    acts : whether this default by itself alters the equations of motion, so that even the shortest
        steps do not obey them; None if unknown, or if steps do not obey them without any default
    """

    name: str
    alone: Errors | None
    without: Errors | None
    acts: bool | None = None


@dataclass(frozen=True)
class DefaultEffects:
    """The effects of all defaults of a method as shipped on a scene, each by itself.

    Attributes
    ----------
    timestep : of all runs, s
    none, all : errors with none and with all of the defaults; None if that run did not finish
    each : the effect of each default
    """

    key: Key
    timestep: float
    none: Errors | None
    all: Errors | None
    each: tuple[DefaultEffect, ...]


def default_effects(rows: Iterable[Row], varied: Iterable[Row]) -> list[DefaultEffects]:
    """Return the effects of defaults, for each method and scene for which they were measured.

    There is an entry for each timestep at which the method has both a run with all of its defaults
    and one with none.

    Parameters
    ----------
    rows : runs in which nothing is varied, among them those of methods as shipped
    varied : runs in which something is varied, among them those with only some defaults
    """
    as_shipped = {(row.key, row.timestep): row for row in rows}
    found: dict[tuple[Key, float], dict[tuple[str, ...], Row]] = {}
    for row in varied:
        names = row.varied.get(DEFAULTS)
        if isinstance(names, list):
            found.setdefault((row.key, row.timestep), {})[tuple(map(str, names))] = row
    return [
        _effects(key, timestep, by_names | {ALL: as_shipped[key, timestep]})
        for (key, timestep), by_names in found.items()
        if (key, timestep) in as_shipped and () in by_names
    ]


#: Stands for the names of all defaults.
ALL = ("all",)


def _effects(key: Key, timestep: float, by_names: Mapping[tuple[str, ...], Row]) -> DefaultEffects:
    """Return the effects of the defaults of a method on a scene, at one timestep.

    Defaults are left out for which the run with that default alone is missing, or the run with all
    but that one.

    Parameters
    ----------
    key : names of scene, engine and method
    timestep : timestep of all these runs, s
    by_names : the runs, by the names of the defaults that they keep; one keeps none, with the key
        `()`, and one all, with the key `ALL`
    """
    names = dict.fromkeys(name for some in by_names if some != ALL for name in some)
    each = []
    none, every = by_names[()], by_names[ALL]
    for name in names:
        others = tuple(other for other in names if other != name)
        if not {(name,), others} <= set(by_names):
            continue
        alone, without = by_names[name,], by_names[others]
        acts = None if none.acts else alone.acts
        each.append(DefaultEffect(name, alone.errors, without.errors, acts))
    return DefaultEffects(key, timestep, none.errors, every.errors, tuple(each))
