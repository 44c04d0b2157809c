"""The motions on a scene's page: those of the result file, to what a picture takes."""

import math
from typing import Any

import numpy as np
import pytest
from made_up import METHODS, STOCK, UNCERTAINTY, at_stock, results
from numpy.typing import NDArray
from spincheck.reports.pages.analysis.report_data import Compared, SceneRuns, report_data
from spincheck.reports.pages.figures.drawn_body import BOX, ELLIPSOID, drawn_body
from spincheck.reports.pages.page_data import Differences
from spincheck.reports.pages.scene.motion_data import (
    DECADES_STEP,
    EXACT_SAMPLES,
    INVISIBLE,
    NOTICEABLE,
    RUN_OMEGA_STEP,
    RUN_SAMPLES,
    RUN_STEP,
    motion_data,
)
from spincheck.scenarios import FloatArray

TOP, BRICK = "made-up-top", "made-up-brick"


def scene(name: str) -> SceneRuns:
    return {scene.name: scene for scene in report_data(at_stock(results())).scenes}[name]


@pytest.fixture(scope="module")
def top() -> SceneRuns:
    return scene(TOP)


@pytest.fixture(scope="module")
def data(top: SceneRuns) -> dict[str, Any]:
    carried = motion_data(top)
    assert carried is not None
    return carried


#: Besides the samples that are spread: the largest errors of attitude and ω, the first above 1°.
SINGLED_OUT = 3


def restored(array: Differences) -> FloatArray:
    values = array.values.astype(float)
    for _ in range(array.order):
        values = np.cumsum(values)
    values *= array.step
    values[list(array.gaps)] = np.nan
    return values


def rows(columns: list[Differences]) -> FloatArray:
    return np.column_stack([restored(column) for column in columns])


def samples(compared: Compared, run: dict[str, Any]) -> NDArray[np.intp]:
    """Which samples of a run are on the page."""
    return np.searchsorted(compared.motion.t, restored(run["t"]) - compared.row.timestep / 4)


def errors(array: Differences) -> FloatArray:
    return np.asarray(10 ** restored(array))


#: Half a step of a logarithm.
HALF = 10 ** (0.51 * DECADES_STEP)


def test_every_run_at_a_stock_timestep_is_there_in_so_many_samples(data: dict[str, Any]) -> None:
    ran = [m for m in METHODS if m.verdict not in ("failed", "unsupported")]
    names = [run["name"] for run in data["runs"]]
    assert len(names) == len(set(names)) == len(ran) * len(STOCK)
    assert len(restored(data["exact"]["t"])) <= EXACT_SAMPLES
    for run in data["runs"]:
        assert len(restored(run["attitude"])) <= RUN_SAMPLES + SINGLED_OUT


def test_attitudes_and_rates_are_those_of_the_run(top: SceneRuns, data: dict[str, Any]) -> None:
    """To half a step; of the two quaternions of an attitude either."""
    drawn = [(c, r) for c, r in zip(top.compared, data["runs"], strict=True) if "q" in r]
    assert drawn
    for compared, run in drawn:
        at = samples(compared, run)
        q, exact_q = rows(run["q"]), compared.motion.q_world_body_wxyz[at]
        sign = np.sign(np.sum(q * exact_q, axis=1, keepdims=True))
        np.testing.assert_allclose(sign * q, exact_q, atol=0.51 * RUN_STEP)
        step = RUN_OMEGA_STEP * data["fastest"]
        np.testing.assert_allclose(
            rows(run["omega_body"]), compared.motion.omega_body[at], atol=0.51 * step
        )


def test_errors_are_those_at_the_samples_that_are_drawn_the_largest_among_them(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    """To half a step of their logarithms; below the reference's uncertainty, that."""
    for compared, run in zip(top.compared, data["runs"], strict=True):
        claimed = np.maximum(compared.series["attitude"], UNCERTAINTY.attitude)
        ratio = errors(run["attitude"]) / claimed[samples(compared, run)]
        assert 1 / HALF < ratio.min() <= ratio.max() < HALF
        assert claimed.max() / HALF < np.nanmax(errors(run["attitude"])) < claimed.max() * HALF
        assert np.nanmin(errors(run["attitude"])) > UNCERTAINTY.attitude / HALF
        assert np.nanmin(errors(run["omega"])) > UNCERTAINTY.omega / HALF


def test_a_run_that_looks_like_the_exact_motion_is_drawn_as_that(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    for compared, run in zip(top.compared, data["runs"], strict=True):
        visible = compared.series["attitude"].max() > INVISIBLE or compared.row.outcome != "ok"
        assert ("q" in run) == visible


def test_a_defect_is_the_largest_since_the_sample_drawn_before(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    for compared, run in zip(top.compared, data["runs"], strict=True):
        at, drawn = samples(compared, run), errors(run["defect"])
        assert np.isnan(drawn[0])
        for first, last, defect in zip(at[:-1], at[1:], drawn[1:], strict=True):
            assert 1 / HALF < defect / compared.defect[first + 1 : last + 1].max() < HALF


def test_where_a_run_goes_wrong_is_its_first_sample_beyond_a_degree(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    noticed = [run["noticed"] for run in data["runs"] if run["noticed"] is not None]
    assert noticed
    for compared, run in zip(top.compared, data["runs"], strict=True):
        beyond = compared.motion.t[compared.series["attitude"] > NOTICEABLE]
        assert run["noticed"] == (beyond[0] if len(beyond) else None)


@pytest.mark.parametrize(("name", "shape"), [(TOP, "ellipsoid"), (BRICK, "box")])
def test_the_solid_drawn_has_the_moments_of_the_body(name: str, shape: str) -> None:
    solved = scene(name).solved
    assert solved is not None
    body = drawn_body(solved)
    squares = body.half_sides**2
    parts = {"box": BOX, "ellipsoid": ELLIPSOID}[shape]
    moments = solved.scenario.body.mass / parts * (squares.sum() - squares)
    assert body.shape == shape
    # A disc without thickness is drawn with some.
    slack = 1e-3 if name == TOP else 8 * np.finfo(float).eps
    np.testing.assert_allclose(moments, np.diag(solved.scenario.body.inertia_com), rtol=slack)


def test_tilt_is_reported_from_gravity_or_from_angular_momentum() -> None:
    top, brick = scene(TOP).solved, scene(BRICK).solved
    assert top is not None
    assert brick is not None
    np.testing.assert_array_equal(drawn_body(top).up_world, [0.0, 0.0, 1.0])
    L = brick.scenario.body.inertia_com @ brick.solution.trajectory.omega_body[0]
    R = brick.solution.trajectory.R_world_body[0]
    along = R.apply(L) / np.linalg.norm(L)
    np.testing.assert_allclose(
        drawn_body(brick).up_world, along, atol=4 * np.finfo(float).eps * math.sqrt(3)
    )
