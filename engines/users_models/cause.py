"""How an engine's body differs from the file's, in words: size and cause."""

from typing import Literal

import numpy as np

from ...scenarios import FloatArray
from ...scenarios.users_models import FileProblem, Stated, principal_moments
from ..checks.read_back import BodyReading
from .difference import AGREES, BodyDifference, moments_alike

#: What an engine did to a link: refused its file; added a body where the file states none, or a
#: tensor where it states only a mass; made a tensor up or set it to zero; lost the rotation of its
#: inertial frame, or the products of inertia; turned the axes; summed fused links wrongly; or any
#: other difference.
Kind = Literal[
    "",
    "refused",
    "nothing stated",
    "no tensor",
    "made up",
    "zero",
    "rotation lost",
    "products dropped",
    "turned",
    "sum",
    "other",
]
#: Ratios this close to 1 are printed as a percentage.
NEAR_ONE = 0.1


def unstated_body(body: BodyReading) -> str:
    """The cause where an engine holds a body and the file has none."""
    return (
        f"held as {body.mass:.3g} kg, {_moments(body.inertia_com)} kg m²: the file states nothing"
    )


def cause(
    stated: Stated,
    body: BodyReading,
    apart: BodyDifference,
    problems: tuple[FileProblem, ...],
    made_up: str,
) -> tuple[Kind, str]:
    """Why an engine's body is not the file's, in a word and in a sentence.

    Parameters
    ----------
    problems : faults of the link's numbers in the file
    made_up : the source of tensors that the engine does not take from the file; else empty
    """
    kind: Kind = "other"
    causes = []
    if apart.mass > AGREES:
        causes.append(f"{body.mass:.6g} kg, not {stated.mass:.6g} kg")
    if apart.com > AGREES:
        distance = float(np.linalg.norm(body.com - stated.com))
        causes.append(f"com {1000 * distance:.3g} mm off")
    if apart.inertia > AGREES:
        kind, sentence = _of_tensor(stated, body.inertia_com, apart, problems, made_up)
        causes.append(sentence)
    return kind, "; ".join(causes)


def _of_tensor(
    stated: Stated,
    got: FloatArray,
    apart: BodyDifference,
    problems: tuple[FileProblem, ...],
    made_up: str,
) -> tuple[Kind, str]:
    size = _size(stated.inertia, got, apart)
    if not got.any():
        why = next((f": {_reason(problem)}" for problem in problems if problem.impossible), "")
        return "zero", f"tensor set to zero{why}"
    if not stated.inertia.any():
        made = f"{made_up}: " if made_up else ""
        return "no tensor", f"{made}{_moments(got)} kg m², the file states a tensor of zero"
    if made_up:
        return "made up", f"{made_up}: {size}"
    if moments_alike(stated.inertia, got):
        rotation_lost = _close(got, stated.unturned)
        why = ": the rotation of its inertial frame is lost" if rotation_lost else ""
        sentence = f"moments kept, axes turned by {apart.axes_deg:.3g}°{why}"
        return ("rotation lost" if rotation_lost else "turned"), sentence
    if _close(got, np.diag(np.diag(stated.inertia))):
        return "products dropped", f"products of inertia dropped: {size}"
    return "other", size


def _reason(problem: FileProblem) -> str:
    """What a problem says, its rule first: "no body has it, 0.3 + 0.1 < 0.9"."""
    text, colon, rule = problem.text.partition(": ")
    return f"{rule}, {text}" if colon else text


def _size(stated: FloatArray, got: FloatArray, apart: BodyDifference) -> str:
    total = float(np.trace(stated))
    ratio = float(np.trace(got)) / total if total > 0 else 0.0
    if ratio <= 0 or abs(ratio - 1) < NEAR_ONE:
        turned = f", axes turned by {apart.axes_deg:.3g}°" if apart.axes_deg > 1 else ""
        return f"tensor off by {apart.inertia:.2%}{turned}"
    if ratio > 1:
        return f"tensor {ratio:.3g} times the file's"
    return f"tensor 1/{1 / ratio:.3g} of the file's"


def _close(one: FloatArray, other: FloatArray) -> bool:
    return bool(np.linalg.norm(one - other) <= AGREES * np.linalg.norm(other))


def _moments(inertia: FloatArray) -> str:
    """The moments as text; one number if all three are equal."""
    moments = principal_moments(inertia)
    alike = moments[2] - moments[0] <= AGREES * abs(moments[2])
    return f"{moments[2]:.3g}" if alike else ", ".join(f"{moment:.3g}" for moment in moments)
