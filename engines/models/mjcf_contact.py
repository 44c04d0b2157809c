"""Writes a table as a contact in MJCF: a sphere on the body touches a plane without friction."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from ...scenarios import Scenario
from ...scenarios.scenario import with_tables
from .text import decimals, xml_text

#: Radius of the sphere that replaces a tip that is a point, as a fraction of the distance from tip
#: to com. The plane is lowered by this radius, so that the tip keeps its height.
SHARE_OF_LEVER = 0.25
#: Height by which the plane is raised, so that in spite of rounding the sphere touches it at the
#: start; relative to the sum of the plane's height, both radii and the distance from tip to com.
TOUCHING = 1e-12
#: MuJoCo's names of the passes that a contact needs.
PASSES = frozenset({"constraint", "contact"})
#: Attributes of sphere and plane: a contact without friction has only a normal force.
FRICTIONLESS = {"condim": "1", "friction": "0 0 0"}


def off_its_table(scenario: Scenario) -> Scenario:
    """Return the scene without its table, as if the body were free, with the same start."""
    effects = scenario.effects.model_copy(update={"table": None})
    return replace(with_tables(scenario, effects=effects), start=scenario.start)


def sphere_and_plane(scenario: Scenario) -> tuple[float, float]:
    """Return the radius of the sphere and the height of the plane that replace a table, m.

    The sphere is a part of the body, with its centre at the tip.
    """
    table, lever = scenario.effects.table, float(np.linalg.norm(scenario.constraint.lever))
    assert table is not None
    radius = table.radius or SHARE_OF_LEVER * lever or 1.0
    height = table.height + table.radius - radius
    return radius, height + TOUCHING * (abs(table.height) + table.radius + radius + lever)


def with_contact(text: str, scenario: Scenario) -> str:
    """Return an MJCF with a sphere added to the body, and a plane under it.

    The time constant and damping ratio of their contact (`solref`) are MuJoCo's defaults.

    Parameters
    ----------
    text : MJCF of the scene without its table, in which contacts are switched on (`PASSES`)
    scenario : the scene with its table
    """
    table, (radius, height) = scenario.effects.table, sphere_and_plane(scenario)
    assert table is not None
    root = ET.fromstring(text)
    world, body = next(root.iter("worldbody")), next(root.iter("body"))
    ET.SubElement(world, "geom", FRICTIONLESS, type="plane", size="1 1 1", pos=f"0 0 {height!r}")
    sphere = ET.SubElement(body, "geom", FRICTIONLESS, type="sphere", mass="0", size=repr(radius))
    sphere.set("pos", decimals(table.tip))
    return xml_text(root)
