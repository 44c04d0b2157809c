"""Other equations and the known integrator that solved them are named, and attitudes that lag."""

import numpy as np
import pytest
from library_scenes import library_scene
from planted_motions import Case, case, exactly, product, rates_of
from reported_faults import Arrays, judged
from scipy.spatial.transform import Rotation
from spincheck.reference import solve
from spincheck.scenarios import from_tables

pytestmark = pytest.mark.slow

FREE, HEAVY = case(324, samples=101), case(321, is_pivoted=True, samples=101)


def semi_implicit(one: Case, timestep: float, **changes: object) -> Arrays:
    """The motion by semi-implicit Euler, of equations with some of them changed."""
    rates, states = rates_of(one, **changes), []
    q, omega = one.scenario.start.q_world_body_wxyz, one.scenario.start.omega_body
    times = one.scenario.times
    for _ in times:
        states.append(np.concatenate([q, omega]))
        for _ in range(round(times[1] / timestep)):
            omega = omega + timestep * rates(q, omega)[1]
            q = q + timestep * product(q, np.array([0, *omega])) / 2
            q = q / np.linalg.norm(q)
    table = np.array(states)
    return {"t": times, "q": table[:, :4], "omega": table[:, 4:]}


OTHER_SIGN = {"inertia": FREE.inertia * (2 * np.eye(3) - 1)}
PRODUCTS = "it moves as if the products of inertia had the other sign"


@pytest.mark.parametrize(
    ("one", "h", "changes", "words"),
    [
        # Here the errors of order 1 are as large as the difference of two changes.
        (FREE, 0.02, OTHER_SIGN, PRODUCTS),
        (HEAVY, 0.002, {"scale": 1.1}, "it moves as if gravity were 1.1 times as strong"),
    ],
)
def test_equations_and_integrator_are_both_named(one, h, changes, words) -> None:
    found = judged(one.scenario, semi_implicit(one, h, **changes), h)
    assert list(found.explained_by) == [
        words,
        f"what is left is what semi-implicit Euler at {h} s makes",
    ]


def test_where_drag_is_missing_no_integrator_that_keeps_the_length_of_L_is_named() -> None:
    """It undoes drag, and so makes the same motion."""
    scene = library_scene("sphere-in-syrup")
    tables = scene.document.model_dump(mode="json", exclude_none=True)
    without = from_tables(tables | {"effects": {}}, "sphere-in-nothing")
    motion = solve(without, scene.times).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    found = judged(scene, arrays, None)
    assert found.explained_by == ("it moves as if there were no drag",)
    assert found.made_by == ""


def test_without_a_timestep_samples_may_be_its_steps() -> None:
    h = FREE.scenario.times[1]
    found = judged(FREE.scenario, semi_implicit(FREE, h, **OTHER_SIGN), None)
    assert found.explained_by == (
        PRODUCTS,
        "what is left is what semi-implicit Euler at 0.04 s makes",
    )
    right = judged(FREE.scenario, semi_implicit(FREE, h), None)
    assert right.explained_by == ()
    assert right.made_by == "what semi-implicit Euler at 0.04 s makes"


def test_numbers_that_an_unknown_method_makes_are_not_fitted() -> None:
    """Implicit drag, (I + h D) ω' = …, is drag about a body with another tensor."""
    h, slowing = 0.02, 0.05
    document = FREE.scenario.document.model_dump(mode="json", exclude_none=True)
    document["effects"] = {"drag": {"rotational": slowing}}
    one = Case(from_tables(document, "planted"), FREE.inertia, FREE.com, FREE.gravity)
    implicit = np.linalg.inv(FREE.inertia + h * slowing * np.eye(3))
    arrays = semi_implicit(one, h, torque=lambda omega: -slowing * omega, inverse=implicit)
    found = judged(one.scenario, arrays, h)
    assert found.explained_by == ()
    assert not found.is_another


def late(q: np.ndarray, samples: float) -> np.ndarray:
    """Attitudes through a filter of first order."""
    out, part = q.copy(), 1 - np.exp(-1 / samples)
    for k in range(1, len(q)):
        out[k] = out[k - 1] + part * (q[k] - out[k - 1])
    return out / np.linalg.norm(out, axis=1)[:, None]


@pytest.mark.parametrize("timestep", [None, 1e-3])
@pytest.mark.parametrize("filters", [1, 2])
def test_attitudes_that_lag_are_named_and_not_the_first_of_them(
    filters: int, timestep: float | None
) -> None:
    one = case(301)
    right = exactly(one, rates_of(one))
    q = right["q"]
    for _ in range(filters):
        q = late(q, 3.0)
    found = judged(one.scenario, right | {"q": q}, timestep)
    (words,) = found.explained_by
    before, _, after = words.partition(" by ")
    assert before == "the attitude is filtered, which delays it"
    # A filter whose time constant is n samples delays what is slow by 1/(e^(1/n) - 1) of them.
    assert float(after.split()[0]) == pytest.approx(filters * 0.02 / (np.exp(1 / 3) - 1), rel=0.05)


@pytest.mark.parametrize("axes", ["body", "world"])
def test_attitudes_since_the_first_sample_are_named(axes: str) -> None:
    right = exactly(FREE, rates_of(FREE))
    turns = Rotation.from_quat(right["q"], scalar_first=True)
    since = turns[0].inv() * turns if axes == "body" else turns * turns[0].inv()
    arrays = right | {"q": since.as_quat(scalar_first=True)}
    (words,) = judged(FREE.scenario, arrays, 1e-3).explained_by
    assert words == (
        "the attitude is relative to that of the first sample, as where it was set to zero, along "
        f"{axes} axes"
    )


@pytest.mark.parametrize("timestep", [None, 0.002])
def test_what_explains_nearly_all_of_a_motion_is_named_within_a_methods_error(
    timestep: float | None,
) -> None:
    """Of samples far apart, by an order of 1, gravity may be off by a tenth."""
    one = case(322, is_pivoted=True, duration=1.0, samples=41)
    arrays = exactly(one, rates_of(one, scale=1 + 2e-3))
    found = judged(one.scenario, arrays, timestep)
    assert found.explained_by == ("it moves as if gravity were 1.002 times as strong",)
    within = found.verdict.endswith("; but what explains it is no method's error")
    assert within != found.is_beyond
    assert within or timestep
    slowed = exactly(one, rates_of(one, scale=1.002, torque=lambda omega: -1e-3 * omega))
    assert sorted(judged(one.scenario, slowed, None).explained_by) == [
        "it moves as if gravity were 1.002 times as strong",
        "it moves as if it were slowed by 0.001 N m s",
    ]
