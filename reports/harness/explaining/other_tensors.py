"""The tensors of inertia that common mistakes lead to in place of a body's own."""

from collections.abc import Iterator, Sequence
from itertools import permutations, product

import numpy as np

from ....scenarios import FloatArray, Scenario

#: Row and column of the six entries of a tensor, in the order in which they are listed everywhere.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: Two tensors count as equal if no entry differs by more than this, relative to the largest entry.
SAME = 1e-9
#: How far a principal moment may exceed the sum of the two others, relative to the largest. For a
#: flat body they are equal, and a fit may be off by as much because of a method's error.
SLACK = 1e-2
#: Numbers of decimals to which a tensor in kg m² may have been rounded.
DECIMALS = range(1, 9)
#: Signs of the principal axes, which are arbitrary: no rotation, and half turns about each axis.
HALF_TURNS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
#: A kind of change, the numbers in its words, and the tensor, kg m², (3, 3).
Tensor = tuple[str, Sequence[float], FloatArray]


def other_tensors(scenario: Scenario) -> Iterator[Tensor]:
    """Yield the different tensors that common mistakes lead to; of equal ones only the first.

    Each comes after the kind of mistake and the numbers that a sentence on it states. The scene's
    own tensor, and tensors that are not positive definite, are left out. All are about the pivot if
    there is one, and else about the com.
    """
    inertia, of_com = np.array(scenario.inertia), np.array(scenario.body.inertia_com)
    seen = [inertia]
    for kind, numbers, wrong in _of_mistakes(scenario, of_com):
        # The scene's tensor is about the pivot, without the axial moments of rotors on free hinges.
        tensor = wrong + (inertia - of_com)
        is_new = all(np.abs(tensor - other).max() > SAME * np.abs(other).max() for other in seen)
        moments = np.linalg.eigvalsh(tensor)
        if is_new and moments[0] > np.finfo(float).eps * moments[2]:
            seen.append(tensor)
            yield kind, numbers, tensor


def _of_mistakes(scenario: Scenario, of_com: FloatArray) -> Iterator[Tensor]:
    """Yield the tensors about the com that common mistakes in stating the inertia lead to.

    Parameters
    ----------
    of_com : the body's tensor about its com, kg m², (3, 3)

    Yields
    ------
    The kind of mistake, the numbers that a sentence on it states, and the tensor; several tensors
    may be equal
    """
    about = scenario.about == "pivot"
    steiner = np.array(scenario.body.inertia_origin) - of_com
    moments, axes = np.linalg.eigh(of_com)
    yield "other products", (), with_products(of_com, -1.0)
    yield "no products", (), with_products(of_com, 0.0)
    orders = [list(order) for order in permutations(range(3))][1:]
    # If the body's axes are principal axes, these tensors include those of the next two mistakes.
    for order in orders:
        permuted = (axes * moments[order]) @ axes.T
        yield "permuted moments", (*moments[order], *moments), permuted
    for tensor in about_conjugated_axes(of_com):
        yield "conjugated axes", (), tensor
    for tensor in without_rotation(of_com):
        yield "without rotation", (), tensor
    yield "com as pivot" if about else "com twice", (), of_com - steiner
    yield "pivot twice" if about else "com as origin", (), of_com + steiner
    for order in orders:
        yield "rows and columns", order, of_com[np.ix_(order, order)]
    for signs in product((1.0, -1.0), repeat=3):
        signed = tensor_entries(of_com) * [1, 1, 1, *signs]
        yield "signs of products", signs, tensors_of_entries(signed)
    entries = tensor_entries(of_com)
    for order in orders:
        exchanged = np.concatenate([entries[:3], entries[3:][order]])
        yield "exchanged products", order, tensors_of_entries(exchanged)
    if about:
        # The term of the parallel axes, m r² 1 - m r rᵀ, has the trace 2 m r².
        yield "parallel axes by distance", (), of_com - steiner + np.eye(3) * np.trace(steiner) / 2
        yield "parallel axes' products", (), of_com - steiner + with_products(steiner, -1.0)
    for decimals in DECIMALS:
        yield "rounded tensor", (decimals,), np.round(of_com, decimals)
    yield "sphere", (), np.eye(3) * moments.mean()


def is_of_a_body(tensor: FloatArray) -> bool:
    """Return whether a rigid body can have a tensor of inertia, (3, 3).

    All principal moments must be positive, and none may exceed the sum of the two others by more
    than `SLACK`.
    """
    least, middle, largest = np.linalg.eigvalsh(tensor)
    return bool(least > 0 and largest <= least + middle + SLACK * largest)


def with_products(tensor: FloatArray, factor: float) -> FloatArray:
    """Return the tensor, (3, 3), with its products of inertia multiplied by a factor."""
    diagonal = np.diag(np.diag(tensor))
    return diagonal + factor * (tensor - diagonal)


def without_rotation(tensor: FloatArray) -> Iterator[FloatArray]:
    """Yield the diagonal tensors, (3, 3), of the principal moments of a tensor, in every order."""
    for order in permutations(np.linalg.eigvalsh(tensor)):
        yield np.diag(order)


def about_conjugated_axes(tensor: FloatArray) -> Iterator[FloatArray]:
    """Yield what a tensor becomes if the rotation to its principal axes is inverted, (3, 3) each.

    There is one for each order and each choice of signs of the principal axes.
    """
    moments, axes = np.linalg.eigh(tensor)
    for order in map(list, permutations(range(3))):
        for signs in HALF_TURNS:
            R = axes[:, order] * signs
            yield R.T @ np.diag(moments[order]) @ R


def tensor_entries(tensor: FloatArray) -> FloatArray:
    """Return the entries Ixx, Iyy, Izz, Ixy, Ixz, Iyz of a tensor, (6,)."""
    return np.array([tensor[i, j] for i, j in ENTRIES])


def tensors_of_entries(entries: FloatArray) -> FloatArray:
    """Return the symmetric tensors, (..., 3, 3), of given entries.

    Parameters
    ----------
    entries : Ixx, Iyy, Izz, Ixy, Ixz and Iyz, (..., 6)
    """
    return np.asarray(entries[..., [[0, 3, 4], [3, 1, 5], [4, 5, 2]]])
