"""The motions on a scene's page: those of the result file, to what a picture takes."""

import base64
import math
from typing import Any

import numpy as np
import pytest
from made_up import METHODS, STOCK, UNCERTAINTY, at_stock, results
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.figures.drawn_body import BOX, ELLIPSOID, drawn_body
from spincheck.reports.pages.motion_data import (
    DECADES_A_STEP,
    EXACT_SAMPLES,
    FULL,
    GAP,
    INVISIBLE,
    LOWEST_DECADE,
    NOTICEABLE,
    RUN_SAMPLES,
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


def decoded(text: str, kind: str) -> FloatArray:
    return np.frombuffer(base64.b64decode(text), dtype=kind).astype(float)


def errors(text: str) -> FloatArray:
    steps = decoded(text, "<u2")
    return np.where(steps == GAP, np.nan, 10 ** (LOWEST_DECADE + DECADES_A_STEP * steps))


def test_every_run_at_a_stock_timestep_is_there(top: SceneRuns, data: dict[str, Any]) -> None:
    ran = [m for m in METHODS if m.verdict not in ("failed", "unsupported")]
    names = [run["name"] for run in data["runs"]]
    assert len(names) == len(set(names)) == len(ran) * len(STOCK)


def test_attitudes_and_rates_are_those_of_the_run(top: SceneRuns, data: dict[str, Any]) -> None:
    """To half a step of 16 bits; the samples are those kept."""
    drawn = [(c, r) for c, r in zip(top.compared, data["runs"], strict=True) if "q" in r]
    assert drawn
    for compared, run in drawn:
        t = decoded(data["times"][run["t"]], "<f4")
        at = np.searchsorted(compared.motion.t, t - 1e-6)
        q = decoded(run["q"], "<i2").reshape(-1, 4) / FULL
        omega = decoded(run["omega_body"], "<i2").reshape(-1, 3) / FULL * run["largest"]
        half = 0.5 / FULL
        np.testing.assert_allclose(q, compared.motion.q_world_body_wxyz[at], atol=1.01 * half)
        np.testing.assert_allclose(
            omega, compared.motion.omega_body[at], atol=1.01 * half * run["largest"]
        )


def test_a_run_that_looks_like_the_exact_motion_is_drawn_as_that(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    for compared, run in zip(top.compared, data["runs"], strict=True):
        visible = compared.series.attitude.max() > INVISIBLE or compared.row.outcome != "ok"
        assert ("q" in run) == visible


def test_the_largest_error_survives_the_thinning(top: SceneRuns, data: dict[str, Any]) -> None:
    for compared, run in zip(top.compared, data["runs"], strict=True):
        largest = max(float(compared.series.attitude.max()), UNCERTAINTY.attitude)
        half = 10 ** (DECADES_A_STEP / 2)
        assert largest / half < np.nanmax(errors(run["attitude"])) < largest * half


def test_no_error_is_carried_below_the_reference(data: dict[str, Any]) -> None:
    half = 10 ** (DECADES_A_STEP / 2)
    for run in data["runs"]:
        assert np.nanmin(errors(run["attitude"])) > UNCERTAINTY.attitude / half
        assert np.nanmin(errors(run["omega"])) > UNCERTAINTY.omega / half


def test_where_a_run_goes_wrong_is_its_first_sample_beyond_a_degree(
    top: SceneRuns, data: dict[str, Any]
) -> None:
    noticed = [run["noticed"] for run in data["runs"] if run["noticed"] is not None]
    assert noticed
    for compared, run in zip(top.compared, data["runs"], strict=True):
        beyond = compared.motion.t[compared.series.attitude > NOTICEABLE]
        assert run["noticed"] == (beyond[0] if len(beyond) else None)


def test_a_page_carries_so_many_samples_and_no_more(data: dict[str, Any]) -> None:
    assert len(decoded(data["exact"]["omega_body"], "<f4")) <= 3 * EXACT_SAMPLES
    for run in data["runs"]:
        assert len(decoded(run["attitude"], "<u2")) <= RUN_SAMPLES


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
