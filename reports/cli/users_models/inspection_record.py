"""An inspection as the contract of `inspect --json` has it."""

from typing import Any

from ....engines.checks.read_back import BodyReading
from ....scenarios.users_models import RigidBody, Stated
from ...harness.users_models import (
    InspectedLink,
    Inspection,
    LinkReading,
    added_masses,
    stated_mass,
)


def record(inspection: Inspection) -> dict[str, Any]:
    """An inspection as a JSON object."""
    return {
        "file": str(inspection.model.path),
        "links": [_link_record(link) for link in inspection.links],
        "summary": {
            "well": inspection.is_well,
            "links": len(inspection.links),
            "stated": sum(is_stated(link) for link in inspection.links),
            "impossible": sum(
                any(p.impossible for p in link.problems) for link in inspection.links
            ),
            "held_wrongly": {
                f"{engine} {configuration}": sum(
                    reading.agrees is False
                    for link in inspection.links
                    for reading in link.readings
                    if (reading.engine, reading.configuration) == (engine, configuration)
                )
                for engine, configuration in columns(inspection)
            },
            "mass": {"stated": stated_mass(inspection), "added": added_masses(inspection)},
            "refused": {" ".join(who): reason for who, reason in inspection.refusals.items()},
            "composed": [
                {"link": body.host.name, "welded": list(body.welded), **_whole_record(body)}
                for body in inspection.composed
            ],
            "notes": list(inspection.model.notes),
        },
    }


def _link_record(link: InspectedLink) -> dict[str, Any]:
    return {
        "link": link.link.name,
        "stated": _body_record(link.link.stated),
        "problems": [
            {"kind": p.kind, "impossible": p.impossible, "text": p.text} for p in link.problems
        ],
        "held": [_reading_record(reading) for reading in link.readings],
    }


def _reading_record(reading: LinkReading) -> dict[str, Any]:
    difference = reading.difference
    apart = reading.attitude_apart_deg
    return {
        "engine": reading.engine,
        "engine_version": reading.engine_version,
        "configuration": reading.configuration,
        **(_body_record(reading.body) or {"mass": None, "com": None, "inertia": None}),
        "agrees": reading.agrees,
        "cause": reading.cause,
        "fused": list(reading.fused),
        "difference": None if difference is None else vars(difference),
        "attitude_apart_deg": apart and {f"{time:g}": angle for time, angle in apart.items()},
    }


def _whole_record(body: RigidBody) -> dict[str, Any]:
    return _body_record(body.stated) or {}


def _body_record(body: Stated | BodyReading | None) -> dict[str, Any] | None:
    if body is None:
        return None
    inertia = body.inertia if isinstance(body, Stated) else body.inertia_com
    return {"mass": body.mass, "com": body.com.tolist(), "inertia": inertia.tolist()}


def columns(inspection: Inspection) -> list[tuple[str, str]]:
    """Engine and configuration of each reading of the file."""
    return [(reading.engine, reading.configuration) for reading in inspection.links[0].readings]


def is_stated(link: InspectedLink) -> bool:
    """Whether the file gives a link a mass and a tensor."""
    return link.link.stated is not None and link.link.stated.is_physical
