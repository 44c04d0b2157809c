"""Corrects a model file so that all engines hold the bodies that it states; lists the changes."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from ...engines import BodyReading
from ...engines.checks.read_back import composed
from ...engines.users_models import (
    WORLD,
    Element,
    Link,
    RigidBody,
    Span,
    edited,
    elements_of,
    principal_moments,
    rigid_bodies,
    set_attributes,
    shapes_box,
    write_inertia,
)
from ...scenarios import FloatArray
from .findings import Finding, grouped
from .inspection import InspectedLink, Inspection

#: Density of a body that is made up, that of water, kg/m³; the least side of the box about a link's
#: shapes, m, which the body fills; and the side of the cube for a link without shapes, m.
WATER, THIN, CUBE = 1000.0, 1e-3, 0.01
#: Least second moment of the nearest possible tensor, relative to the largest moment of inertia, so
#: that rounding does not make the tensor impossible again.
LEAST_SPREAD = 1e-6
#: Matrix that takes the second moments along the principal axes, S = Σ m x², to the moments of
#: inertia: I1 = S2 + S3, and so on.
MOMENTS_BY_SPREAD = np.ones((3, 3)) - np.eye(3)
#: The body of a link that is written as massless.
NOTHING = BodyReading(0.0, np.zeros(3), np.zeros((3, 3)))
#: Comment that is written into the file before an inertia that is made up.
REMARK = "made up by spincheck"


@dataclass(frozen=True)
class Wishes:
    """Changes that are made only if a user asks for them.

    Attributes
    ----------
    nearest : whether an impossible tensor is replaced by the nearest possible one
    made_up : whether an inertia is made up for links that move and have none
    compose : whether links that are welded together are written as one link with the mass of all,
        and the others as massless
    """

    nearest: bool = False
    made_up: bool = False
    compose: bool = False


@dataclass(frozen=True)
class Mended:
    """A model as it is to be written.

    Attributes
    ----------
    data : the content of the corrected file
    changes : what was changed
    left : faults that remain, as they cannot be corrected or the user did not ask for it
    """

    data: bytes
    changes: list[Finding]
    left: list[Finding]


#: For each link, by name, the body that is to be written and, in words, what that changes. If the
#: body is None, the link is left as it is, and the words say why; they are empty without a fault.
Plan = dict[str, tuple[BodyReading | None, str]]


def mended(inspection: Inspection, wishes: Wishes) -> Mended:
    """Return the model with corrected inertias, whose tensors are written along the links' axes.

    Two settings are removed: Bullet's `inertia_scaling`, and MuJoCo's `inertiafromgeom="true"` if
    all bodies that need it get a stated inertia. All else in the file stays as it is.

    Parameters
    ----------
    inspection : the model, and the bodies that engines hold
    wishes : which optional changes are made
    """
    model = inspection.model
    elements = elements_of(model)
    plan = _plan(inspection, wishes)
    changes, left = [], []
    edits: dict[Span, bytes] = {}
    for link in model.links:
        body, words = plan[link.name]
        if link.stated and body is None and _lacks_place(elements.get(link.span)):
            body, words = link.stated, "'pos' written, without which MuJoCo refuses the file"
        if body is not None and link.span in elements:
            remark = REMARK if words.startswith("made up") else ""
            edits |= dict(write_inertia(model, elements[link.span], body, remark))
            changes.append(("", words, link.name))
        elif body is not None:
            left.append(("", "it is in a file that this one includes: mend that", link.name))
        elif words:
            left.append(("", words, link.name))
    shaped = [link for link in model.links if link.by_shapes]
    all_stated = all(link.span in elements and plan[link.name][0] for link in shaped)
    for element in elements.values():
        if element.tag == "inertia_scaling":
            edits[element.span] = b""
            changes.append(("", f"{element} taken away, which only Bullet reads", "the file"))
        if element.attributes.get("inertiafromgeom") == "true" and all_stated:
            edits |= [set_attributes(model.data, element, {"inertiafromgeom": None})]
            changes.append(("", "'inertiafromgeom' taken away: bodies state theirs", "the file"))
    return Mended(edited(model.data, list(edits.items())), grouped(changes), grouped(left))


def _lacks_place(element: Element | None) -> bool:
    inertials = [] if element is None or element.tag != "body" else element.all("inertial")
    return any("pos" not in inertial.attributes for inertial in inertials)


def _plan(inspection: Inspection, wishes: Wishes) -> Plan:
    links = inspection.model.links
    wholes = rigid_bodies(links)
    # MuJoCo refuses links without mass or tensor that move.
    massless = {
        whole.host.name
        for whole in wholes
        if whole.host.moves
        and not any(part.by_shapes or part.has_inertia for part, _ in whole.parts)
    }
    plan = {
        one.link.name: _alone(one, inspection.model.format, one.link.name in massless, wishes)
        for one in inspection.links
    }
    for whole in wholes if wishes.compose else ():
        _compose(whole, plan)
    return plan


def _compose(whole: RigidBody, plan: Plan) -> None:
    """Plan that the link to which others are welded states the mass of all, and these are massless.

    If one of the links cannot be corrected, they are not composed.

    Parameters
    ----------
    whole : the link with those that are welded to it
    plan : what is written for each link; changed in place
    """
    parts = [
        (link.name, body.placed(pose.position, pose.R))
        for link, pose in whole.parts
        if (body := plan[link.name][0] or link.stated) is not None and body.mass
    ]
    host, names = whole.host.name, {whole.host.name, *(name for name, _ in parts)}
    others = ", ".join(sorted(names - {host}))
    if not others:
        return
    if any(plan[name][0] is None and plan[name][1] for name in names):
        plan[host] = (None, f"not written as one body with {others}, of which some are left")
        return
    for name in names:
        body, words = NOTHING, f"stated as part of {host}"
        if name == host:
            body = composed([part for _, part in parts])
            words = f"written as one body with {others}"
        plan[name] = (body, "; ".join(filter(None, (plan[name][1], words))))


def _alone(
    inspected: InspectedLink, form: str, massless: bool, wishes: Wishes
) -> tuple[BodyReading | None, str]:
    """Return the body that is to be written for a link, without regard to links welded to it.

    Parameters
    ----------
    inspected : the link, its faults, and the bodies that engines hold
    form : format of the file, "urdf" or "mjcf"
    massless : whether the link moves, and neither it nor any link welded to it has an inertia
    wishes : which optional changes are made

    Returns
    -------
    The body, or None if the link is left as it is; and, in words, what is changed, or why nothing
    is. The words are empty if the link has no fault
    """
    link, stated = inspected.link, inspected.link.stated
    if link.by_shapes:
        of_shapes = next((one.body for one in inspected.readings if one.body is not None), None)
        if of_shapes is None:
            return None, "its inertia is that of its shapes, and no engine reads the file"
        return of_shapes, "the inertia of its shapes, as MuJoCo computes it"
    kinds = [problem.kind for problem in inspected.problems if problem.impossible]
    if kinds == ["zero tensor"] or (massless and not kinds):
        return _without_inertia(link, wishes)
    if stated is None:
        if form == "mjcf" or link.name == WORLD:
            return None, ""
        fixed = "" if link.parent else ": MuJoCo and PyBullet fix such a root in the world"
        return NOTHING, f"stated to have no mass, as URDF has it{fixed}"
    if kinds:
        before = stated.inertia_com
        tensor = nearest_possible(before) if stated.mass > 0 else None
        if tensor is None or not wishes.nearest:
            offer = "" if tensor is None else "; '--nearest' writes the nearest that one has"
            return None, f"{'; '.join(one.text for one in inspected.problems)}{offer}"
        was, now = (
            ", ".join(f"{moment:.4g}" for moment in principal_moments(one))
            for one in (before, tensor)
        )
        body = BodyReading(stated.mass, stated.com, tensor)
        size, apart = (float(np.linalg.norm(one)) for one in (before, tensor - before))
        words = f"nearest possible tensor, {apart / size:.2g} of its norm off"
        return body, f"{words}: moments {now} kg m² for {was}"
    if (stated.unturned != stated.inertia_com).any():
        return stated, "tensor written along the link's axes, without a rotation"
    return None, ""


def _without_inertia(link: Link, wishes: Wishes) -> tuple[BodyReading | None, str]:
    """Return a body that is made up for a link without tensor or mass, and words on its origin.

    Its tensor is that of a uniform box around the link's shapes. Its mass and com are those that
    the file states, else those of this box filled with water. If `wishes` does not ask for made-up
    bodies, the body is None, and the words say what is missing.
    """
    if not wishes.made_up:
        return None, "it has no mass, or no tensor; '--made-up' makes one up from its shapes"
    box, words = shapes_box(link), "made up: that of the box about its shapes"
    if box is None:
        box = np.array([[-CUBE / 2] * 3, [CUBE / 2] * 3])
        words = f"made up: that of a cube of {100 * CUBE:g} cm, as its shapes are not known"
    low, high = box
    sides = np.maximum(high - low, THIN)
    mass, com = WATER * float(np.prod(sides)), (low + high) / 2
    if link.stated is not None and link.stated.mass > 0:
        mass, com = link.stated.mass, link.stated.com
    inertia = np.diag(MOMENTS_BY_SPREAD @ sides**2) * mass / 12
    return BodyReading(mass, com, inertia), words


def nearest_possible(inertia: FloatArray) -> FloatArray | None:
    """Return the possible tensor nearest to an impossible one, kg m², (3, 3).

    The distance is the Frobenius norm of the difference. As rotations do not change this norm, the
    nearest tensor has the same principal axes. Its moments are found by least squares, under the
    condition that the second moments are not negative (Lawson & Hanson, Solving Least Squares
    Problems, ch. 23). None is returned if the fitted second moments are all zero.

    Parameters
    ----------
    inertia : the impossible tensor, kg m², (3, 3), symmetric
    """
    moments, axes = np.linalg.eigh(inertia)
    scale = float(np.abs(moments).max())
    least = np.full(3, LEAST_SPREAD)
    spread, _ = nnls(MOMENTS_BY_SPREAD, moments / scale - MOMENTS_BY_SPREAD @ least)
    if not spread.any():
        return None
    near = axes @ np.diag(scale * MOMENTS_BY_SPREAD @ (spread + least)) @ axes.T
    return np.asarray((near + near.T) / 2)
