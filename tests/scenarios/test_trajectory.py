"""A trajectory is valid if it exists, and stays what it was."""

import pickle

import numpy as np
import pytest
from case_loops import each_case
from scipy.spatial.transform import Rotation
from spincheck.scenarios import Trajectory

N = 4
COLUMNS = {
    "t": np.arange(N, dtype=float),
    "q_world_body_wxyz": Rotation.random(N, rng=1).as_quat(scalar_first=True),
    "omega_body": np.arange(3.0 * N).reshape(N, 3),
    "com_world": np.ones((N, 3)),
    "velocity_world": np.zeros((N, 3)),
}


def trajectory(**changes):
    return Trajectory(**{**COLUMNS, **changes})


@pytest.mark.parametrize("name", COLUMNS)
def test_its_arrays_are_read_only_copies_out_of_another_process_too(name):
    columns = {key: values.copy() for key, values in COLUMNS.items()}
    motion = Trajectory(**columns)
    columns[name][0] = 0.5
    for one in (motion, pickle.loads(pickle.dumps(motion))):
        assert np.array_equal(getattr(one, name), COLUMNS[name])
        with pytest.raises(ValueError, match="read-only"):
            getattr(one, name)[0] = 7.0


def test_its_fields_cannot_be_replaced():
    with pytest.raises(AttributeError, match="cannot assign"):
        trajectory().t = COLUMNS["t"]


def test_lists_and_integers_become_doubles():
    motion = trajectory(t=[0, 1, 2, 3], com_world=[[0, 0, 1]] * N)
    assert motion.t.dtype == motion.com_world.dtype == np.float64


def spoilt(name, value):
    return np.append(COLUMNS[name].ravel()[:-1], value).reshape(COLUMNS[name].shape)


def stretched(part):
    """Attitudes whose norms are off by a part of what is allowed."""
    return {"q_world_body_wxyz": COLUMNS["q_world_body_wxyz"] * (1 + part * SLACK)}


SLACK, VECTORS = Trajectory.UNIT_NORM_SLACK, [name for name in COLUMNS if name != "t"]
REFUSED = [
    *(({n: COLUMNS[n][:-1]}, rf"'{n}' must have shape \(4, ") for n in VECTORS),
    *(({n: COLUMNS[n][:, :-1]}, rf"'{n}' must have shape \(4, ") for n in VECTORS),
    *(({"t": t}, "'t' must have one dimension") for t in (COLUMNS["t"][:, None], 0.0)),
    *(({n: spoilt(n, x)}, "finite throughout") for n in COLUMNS for x in (np.nan, np.inf)),
    *(({"t": t}, "'t' must increase") for t in ([0, 1, 1, 2], [0, 2, 1, 3])),
    (stretched(2), "must have unit norm"),
]


@each_case(("changes", "words"), REFUSED)
def test_what_is_no_motion_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        trajectory(**changes)


def test_attitudes_are_of_unit_norm_to_single_precision():
    trajectory(**stretched(0.5))


def test_attitudes_take_body_components_to_world_components():
    q = np.tile([np.sqrt(0.5), 0, np.sqrt(0.5), 0], (N, 1))
    x_of_body_z = trajectory(q_world_body_wxyz=q).R_world_body.apply([0, 0, 1])[:, 0]
    assert x_of_body_z == pytest.approx(1)


def test_the_first_samples_are_a_trajectory():
    first = trajectory().until(2)
    assert list(first.t) == [0, 1]
    assert np.array_equal(first.omega_body, COLUMNS["omega_body"][:2])


def test_an_empty_trajectory_is_one():
    assert len(trajectory().until(0).t) == 0
