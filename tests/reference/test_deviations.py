"""Deviations of states are those of the rotation from one attitude to the other, and of ω."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.reference.deviations import apart
from spincheck.scenarios.rotation import rotation_vectors

RANDOM = np.random.default_rng(5)
STATES = np.hstack([Rotation.random(8, rng=RANDOM).as_quat(), RANDOM.normal(size=(8, 3))])


def test_the_turn_leads_from_one_attitude_to_the_other_and_is_the_shorter_one():
    other = np.hstack([Rotation.random(8, rng=RANDOM).as_quat(), RANDOM.normal(size=(8, 3))])
    turned, faster = np.split(apart(STATES, other), 2, axis=1)
    first, last = (Rotation.from_quat(one[:, :4], scalar_first=True) for one in (STATES, other))
    assert ((first * Rotation.from_rotvec(turned)).inv() * last).magnitude().max() < 1e-14
    assert np.linalg.norm(turned, axis=1).max() <= np.pi
    assert (faster == other[:, 4:] - STATES[:, 4:]).all()


def test_a_quaternion_and_its_negative_are_one_attitude_and_several_motions_are_compared():
    negative = STATES * np.repeat([-1.0, 1.0], [4, 3])
    both = apart(np.stack([STATES, negative]), STATES)
    assert both.shape == (2, 8, 6)
    assert not both.any()


def test_the_turns_are_those_that_python_computes():
    other = STATES[::-1]
    turned = rotation_vectors(STATES[:, :4], other[:, :4])
    assert apart(STATES, other)[:, :3] == pytest.approx(turned, abs=4e-15)


def test_of_no_states_there_are_none():
    assert apart(STATES[:0], STATES[:0]).shape == (0, 6)


def test_what_is_not_finite_stays_so():
    assert np.isnan(apart(np.full((1, 7), np.nan), STATES[:1])).all()
