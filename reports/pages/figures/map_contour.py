"""Where a function known on a grid is zero: marching squares.

W. E. Lorensen & H. E. Cline, Marching cubes, Computer Graphics 21, 163 (1987), in two dimensions.
A cell with alternating signs at its corners is cut twice; their mean decides in which way.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray

#: An edge of the grid: from node (row, column) along the row (0) or down the column (1).
Edge = tuple[int, int, int]


def zero_lines(x: FloatArray, y: FloatArray, values: FloatArray) -> list[FloatArray]:
    """The curves on which linear interpolation between neighbouring nodes is zero.

    Parameters
    ----------
    x, y : (columns,) and (rows,), increasing
    values : (rows, columns); cells with a corner that is not finite are left out

    Returns
    -------
    curves, (n, 2) each: x and y of points along it; a closed one ends where it begins
    """
    positive = values >= 0
    joined: dict[Edge, list[Edge]] = {}
    rows, columns = values.shape
    for row in range(rows - 1):
        for column in range(columns - 1):
            corners = values[row : row + 2, column : column + 2]
            if not np.isfinite(corners).all():
                continue
            signs = positive[row : row + 2, column : column + 2]
            for one, other in _cuts(row, column, signs, float(corners.mean()) >= 0):
                joined.setdefault(one, []).append(other)
                joined.setdefault(other, []).append(one)
    return [np.array([_point(edge, x, y, values) for edge in chain]) for chain in _chains(joined)]


def _cuts(
    row: int, column: int, positive: NDArray[np.bool_], middle: bool
) -> Iterator[tuple[Edge, Edge]]:
    """Pairs of a cell's edges that the curve joins."""
    top, bottom = (row, column, 0), (row + 1, column, 0)
    left, right = (row, column, 1), (row, column + 1, 1)
    (a, b), (c, d) = positive.tolist()
    crossed = [
        edge
        for edge, differ in ((top, a != b), (right, b != d), (bottom, c != d), (left, a != c))
        if differ
    ]
    if len(crossed) == 2:
        yield crossed[0], crossed[1]
    elif len(crossed) == 4:
        # Corner a is on the middle's side: the other two corners are cut off; else a and d are.
        pairs = ((top, right), (bottom, left)) if a == middle else ((top, left), (right, bottom))
        yield from pairs


def _chains(joined: dict[Edge, list[Edge]]) -> Iterator[list[Edge]]:
    """Edges in the order in which a curve crosses them: open curves first, then closed ones."""
    ends = [edge for edge, neighbours in joined.items() if len(neighbours) == 1]
    seen: set[Edge] = set()
    for start in [*ends, *joined]:
        if start in seen:
            continue
        chain = [start]
        seen.add(start)
        while following := [edge for edge in joined[chain[-1]] if edge not in seen]:
            chain.append(following[0])
            seen.add(following[0])
        closed = len(chain) > 2 and start in joined[chain[-1]]
        yield [*chain, start] if closed else chain


def _point(edge: Edge, x: FloatArray, y: FloatArray, values: FloatArray) -> tuple[float, float]:
    row, column, down = edge
    here = float(values[row, column])
    there = float(values[row + down, column + 1 - down])
    part = here / (here - there)
    if down:
        return float(x[column]), float(y[row] + part * (y[row + 1] - y[row]))
    return float(x[column] + part * (x[column + 1] - x[column])), float(y[row])
