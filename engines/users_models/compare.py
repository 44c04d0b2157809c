"""Compares an engine's body with the one that a model file states, and tells why they differ."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray
from ..checks.read_back import BodyReading
from .file_problems import FileProblem, problems_of_parts
from .model_file import RigidBody, Stated, principal_moments

#: Largest relative difference of bodies that count as equal. Some engines diagonalise tensors with
#: errors of 1e-12 to 1e-6: with a tolerance of 1e-12 a third of all links would count as wrong.
AGREES = 1e-5
#: The identity and the half turns about each axis: they only change signs of principal axes.
_SIGNS = [np.diag(signs) for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))]
#: Largest distance of a ratio from 1 with which the difference is printed as a percentage.
NEAR_ONE = 0.1


@dataclass(frozen=True)
class BodyDifference:
    """How far an engine's body is from the body that a file states.

    Attributes
    ----------
    mass : difference of the masses, relative to the file's
    com : distance of the coms, relative to the radius of gyration or |com| of the file's body,
        whichever is larger
    inertia : norm of the difference of the tensors about the com, relative to the file's tensor
    axes_deg : the smallest rotation from the file's principal axes to the engine's, degrees; axes
        that equal moments leave undetermined are not compared (`angle_between_axes`)
    """

    mass: float
    com: float
    inertia: float
    axes_deg: float

    @property
    def worst(self) -> float:
        """The largest of the relative differences: of mass, com and inertia."""
        return max(self.mass, self.com, self.inertia)


def difference(stated: BodyReading, got: BodyReading) -> BodyDifference:
    """Return the difference between an engine's body and the one that a file states.

    If the file states zero for a quantity, its relative difference is 0 if the engine has zero too,
    else infinite.

    Parameters
    ----------
    stated, got : the body that the file states, and the engine's
    """
    inertia = stated.inertia_com
    arm = max(radius_of_gyration(stated), float(np.linalg.norm(stated.com)))
    return BodyDifference(
        mass=_relative(abs(got.mass - stated.mass), abs(stated.mass)),
        com=_relative(float(np.linalg.norm(got.com - stated.com)), arm),
        inertia=_relative(
            float(np.linalg.norm(got.inertia_com - inertia)), float(np.linalg.norm(inertia))
        ),
        axes_deg=float(np.degrees(angle_between_axes(inertia, got.inertia_com))),
    )


def radius_of_gyration(body: BodyReading) -> float:
    """Return the radius of gyration of a body about its com, m; 0 if it has no mass."""
    if not body.mass:
        return 0.0
    # For a tiny mass it may overflow to infinity.
    with np.errstate(over="ignore"):
        return float(np.sqrt(abs(np.trace(body.inertia_com)) / (2 * abs(body.mass))))


def _relative(value: float, size: float) -> float:
    """Return a value divided by a size; if the size is zero, 0 for a value of zero, else inf."""
    if size:
        return value / size
    return 0.0 if value == 0 else float("inf")


def angle_between_axes(one: FloatArray, other: FloatArray) -> float:
    """Return the angle of the smallest rotation from one tensor's principal axes to another's, rad.

    Axes are paired by the order of their moments. Where two moments of either tensor are equal,
    their axes may be chosen freely, and only the third axis is compared; 0 is returned if no axis
    is left.

    Parameters
    ----------
    one, other : tensors, (3, 3), each symmetric
    """
    (moments, axes), (other_moments, other_axes) = np.linalg.eigh(one), np.linalg.eigh(other)
    free = _equal_pairs(moments) | _equal_pairs(other_moments)
    if free == {0, 1}:
        return 0.0
    if free:
        # Only one axis is determined; the other two may turn about it.
        lone = 2 if free == {0} else 0
        cosine = abs(axes[:, lone] @ other_axes[:, lone])
        sine = np.linalg.norm(np.cross(axes[:, lone], other_axes[:, lone]))
        return float(np.arctan2(sine, cosine))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    other_axes[:, 2] *= np.sign(np.linalg.det(other_axes))
    turns = [other_axes @ sign @ axes.T for sign in _SIGNS]
    return float(min(Rotation.from_matrix(turn).magnitude() for turn in turns))


def _equal_pairs(moments: FloatArray) -> set[int]:
    """Return which neighbours of three ascending moments are equal.

    The set contains 0 if the lower two are equal, and 1 if the upper two are.
    """
    gaps = np.diff(moments)
    return {k for k in (0, 1) if gaps[k] <= AGREES * np.abs(moments).max()}


def compared(
    stated: Stated, got: BodyReading, body: RigidBody, made_up: str
) -> tuple[BodyDifference, str, str]:
    """Return how far an engine's body is from the file's, and why, in a word and in a sentence.

    Parameters
    ----------
    stated, got : the body that the file states, and the engine's
    body : the links of the file that the engine holds as this body
    made_up : where the engine's tensors come from, in words; empty if from the file

    Returns
    -------
    The difference, and the word and the sentence of `cause`, which are empty if the bodies agree
    """
    apart = difference(stated, got)
    if apart.worst <= AGREES:
        return apart, "", ""
    faults = tuple(problem for _, problem in problems_of_parts(body))
    return apart, *cause(stated, got, apart, faults, made_up)


def unstated_body(body: BodyReading) -> str:
    """Return a sentence on an engine's body for which the file states no mass and no tensor."""
    return (
        f"held as {body.mass:.3g} kg, {_moments(body.inertia_com)} kg m²: the file states nothing"
    )


def cause(
    stated: Stated,
    body: BodyReading,
    apart: BodyDifference,
    problems: tuple[FileProblem, ...],
    made_up: str,
) -> tuple[str, str]:
    """Return why an engine's body is not the file's, in a word and in a sentence.

    The word is "zero" if the engine's tensor is zero, "no tensor" if the file states only a mass,
    "made up" if the engine does not take tensors from the file, "rotation lost" if it ignores the
    rotation of the inertial frame, "turned" if only the principal axes differ, "products dropped"
    if it ignores products of inertia, or "other".

    Parameters
    ----------
    stated, body : the body that the file states, and the engine's
    apart : how far they are from each other
    problems : faults of the numbers that the file states for the body's links
    made_up : where the engine's tensors come from, in words; empty if from the file
    """
    kind = "other"
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
) -> tuple[str, str]:
    """Return why an engine's tensor is not the file's, in a word and a sentence; see `cause`.

    Parameters
    ----------
    stated : the body that the file states
    got : the engine's tensor about the com, kg m², (3, 3)
    apart : how far the engine's body is from the file's
    problems : faults of the numbers that the file states for the body's links
    made_up : where the engine's tensors come from, in words; empty if from the file
    """
    tensor = stated.inertia_com
    size = _size(tensor, got, apart)
    if not got.any():
        return "zero", f"tensor set to zero{_why(problems)}"
    if not tensor.any():
        made = f"{made_up}: " if made_up else ""
        return "no tensor", f"{made}{_moments(got)} kg m², the file states a tensor of zero"
    if made_up:
        return "made up", f"{made_up}: {size}"
    if _close(principal_moments(got), principal_moments(tensor)):
        lost = _close(got, stated.unturned)
        why = ": the rotation of its inertial frame is lost" if lost else ""
        sentence = f"moments kept, axes turned by {apart.axes_deg:.3g}°{why}"
        return ("rotation lost" if lost else "turned"), sentence
    if _close(got, np.diag(np.diag(tensor))):
        return "products dropped", f"products of inertia dropped: {size}"
    return "other", size


def _why(problems: tuple[FileProblem, ...]) -> str:
    """Return a text on the first fault that makes a body impossible; empty if there is none.

    The rule comes before the numbers, for example ": no body has it, 0.3 + 0.1 < 0.9".
    """
    for problem in problems:
        if problem.impossible:
            text, colon, rule = problem.text.partition(": ")
            return f": {rule}, {text}" if colon else f": {text}"
    return ""


def _size(stated: FloatArray, got: FloatArray, apart: BodyDifference) -> str:
    """Return, in words, by how much a tensor `got` differs from the file's, `stated`.

    `apart` has how far the bodies are apart, as numbers.
    """
    total = float(np.trace(stated))
    ratio = float(np.trace(got)) / total if total > 0 else 0.0
    if ratio <= 0 or abs(ratio - 1) < NEAR_ONE:
        turned = f", axes turned by {apart.axes_deg:.3g}°" if apart.axes_deg > 1 else ""
        return f"tensor off by {apart.inertia:.2%}{turned}"
    if ratio > 1:
        return f"tensor {ratio:.3g} times the file's"
    return f"tensor 1/{1 / ratio:.3g} of the file's"


def _close(one: FloatArray, other: FloatArray) -> bool:
    """Whether two tensors differ by no more than `AGREES`, relative to the norm of `other`."""
    return bool(np.linalg.norm(one - other) <= AGREES * np.linalg.norm(other))


def _moments(inertia: FloatArray) -> str:
    """Return the principal moments of a tensor as text; one number if all three are equal."""
    moments = principal_moments(inertia)
    alike = moments[2] - moments[0] <= AGREES * abs(moments[2])
    return f"{moments[2]:.3g}" if alike else ", ".join(f"{moment:.3g}" for moment in moments)
