"""Motions that are exact for a body other than the scene's, with no timestep stated."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from planted_motions import Case, case, exactly, rates_of, stepped
from spincheck.reports.harness.explaining.other_tensors import other_tensors
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import Scenario, from_tables

SAMPLES = 801
ONE = case(71, is_pivoted=True, samples=SAMPLES)
MASS = ONE.scenario.body.mass
OF_COM = np.array(ONE.scenario.body.inertia_com)
PARALLEL = ONE.inertia - OF_COM


def with_inertia(one: Case, tensor: np.ndarray) -> Scenario:
    tables = one.scenario.document.model_dump(mode="json", exclude_none=True)
    tables["body"]["inertia"] = tensor.tolist()
    return from_tables(tables, "thin")


def judged(one: Case, arrays: dict[str, np.ndarray], **stated: str) -> JudgedMotion:
    return judged_motion(one.scenario, Recording(Path("motion.csv"), arrays, stated), 1)


def exchanged(tensor: np.ndarray) -> np.ndarray:
    """Ixy and Iyz in each other's place."""
    other = tensor.copy()
    other[0, 1] = other[1, 0] = tensor[1, 2]
    other[1, 2] = other[2, 1] = tensor[0, 1]
    return other


def with_more(tensor: np.ndarray, at: tuple[int, int], more: float) -> np.ndarray:
    other = tensor.copy()
    other[at] += more
    other[at[::-1]] = other[at]
    return other


WRONG: dict[str, tuple[Callable[[], np.ndarray], str]] = {
    "one entry": (
        lambda: with_more(ONE.inertia, (0, 2), 0.01),
        f"Ixz were {ONE.inertia[0, 2] + 0.01:.7g} kg m², 0.01 more than it is",
    ),
    "exchanged": (lambda: exchanged(OF_COM) + PARALLEL, "Ixy, Ixz and Iyz were Iyz, Ixz and Ixy"),
    "rounded": (lambda: np.round(OF_COM, 2) + PARALLEL, "rounded to 2 decimals"),
    "distance alone": (
        lambda: OF_COM + MASS * (ONE.com @ ONE.com) * np.eye(3),
        "added m r² along every axis, without − m r rᵀ",
    ),
    "other sign": (
        lambda: OF_COM + 2 * np.diag(np.diag(PARALLEL)) - PARALLEL,
        "products of the parallel axis theorem had the other sign",
    ),
    "another body": (
        lambda: ONE.inertia * 1.1 + 0.02 * np.array([[2, 1, 1], [1, -1, 0], [1, 0, 1]]),
        "the tensor were Ixx",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_the_tensor_of_an_exact_motion_is_named_without_a_timestep(name: str) -> None:
    tensor, words = WRONG[name]
    found = judged(ONE, exactly(ONE, rates_of(ONE, inertia=tensor())))
    assert len(found.explained_by) == 1
    assert words in found.explained_by[0]


def test_gravity_that_acts_on_a_free_body_is_named() -> None:
    free = case(72, samples=SAMPLES)
    gravity = np.array([0.0, 0.0, -1.0])
    tables = free.scenario.document.model_dump(mode="json", exclude_none=True)
    tables["effects"] = {"gravity": {"acceleration": gravity.tolist()}}
    scenario = from_tables(tables, "falling")
    pulled = replace(free, scenario=scenario, gravity=gravity)
    found = judged(pulled, exactly(pulled, rates_of(pulled)))
    assert len(found.explained_by) == 1
    assert "gravity acted on the com about the body's origin" in found.explained_by[0]


def test_a_tensor_that_rounds_to_none_is_no_candidate() -> None:
    thin = with_inertia(case(73), np.diag([0.4, 0.4, 0.04]))
    kinds = [(kind, tuple(n)) for kind, n, _ in other_tensors(thin)]
    assert ("rounded tensor", (1,)) not in kinds
    assert all(np.isfinite(np.linalg.inv(tensor)).all() for _, _, tensor in other_tensors(thin))


@pytest.mark.parametrize("order", [1, 2])
def test_the_error_of_a_method_is_no_other_body(order: int) -> None:
    scene, chance = ONE.scenario, np.random.default_rng(3)
    made = stepped(scene, rates_of(ONE), order, float(scene.times[1]), chance)
    assert judged(ONE, made).explained_by == ()
