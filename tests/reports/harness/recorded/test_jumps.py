"""Where a motion is the exact one from nearly every sample on, the others are told, and counted."""

import numpy as np
import pytest
from planted_motions import case, exactly, rates_of
from reported_faults import Arrays, judged
from scipy.spatial.transform import Rotation

pytestmark = pytest.mark.slow

ONE = case(61, samples=201)
RIGHT = exactly(ONE, rates_of(ONE))
T = RIGHT["t"]


def with_omega(*samples: int) -> Arrays:
    """ω turned round in pairs of samples."""
    omega = RIGHT["omega"].copy()
    for k in samples:
        omega[k : k + 2] *= -1
    return RIGHT | {"omega": omega}


def later(turn: Rotation, samples: slice) -> Arrays:
    """Attitudes of some samples turned in the world, without a turn of ω."""
    q = RIGHT["q"].copy()
    q[samples] = (turn * Rotation.from_quat(q[samples], scalar_first=True)).as_quat(
        scalar_first=True
    )
    return RIGHT | {"q": q}


def stopped_following() -> Arrays:
    """Attitudes that turn by half of ω for some samples."""
    turns = Rotation.from_quat(RIGHT["q"], scalar_first=True)
    steps = turns[:-1].inv() * turns[1:]
    made = [turns[0]]
    for k in range(len(steps)):
        step = Rotation.from_rotvec(steps[k].as_rotvec() / (2 if 90 <= k < 96 else 1))
        made.append(made[-1] * step)
    return RIGHT | {"q": np.array([one.as_quat(scalar_first=True) for one in made])}


def hitch() -> Arrays:
    """The clock goes on for six samples' time, and the motion for one."""
    return RIGHT | {"t": T + 0.1 * (np.arange(201) > 80)}


#: Words that must be said, and by which they must begin.
PLANTED = {
    "pairs of samples": (
        with_omega(50, 90, 140),
        "2 samples, from t = 1 s to 1.02 s, are off, the first by ",
        "leave them out (one of 3 such places, the last at 2.8 s)",
    ),
    "a run of samples": (
        later(Rotation.from_rotvec([0, 0, 2.0]), slice(60, 90)),
        "30 samples, from t = 1.2 s to 1.78 s, are off, the first by 115° and 0 rad/s; after them ",
        "the motion goes on as before: leave them out",
    ),
    "a stretch": (
        stopped_following(),
        "from t = 1.8 s to 1.92 s the attitude does not follow ω, by up to ",
        "from one sample to the next",
    ),
    "a clock": (
        hitch(),
        "from t = 1.6 s to 1.72 s the motion goes on by 0.02 s, and the times by 0.12 s",
        "",
    ),
}


@pytest.mark.parametrize("timestep", [None, 1e-3])
@pytest.mark.parametrize("fault", PLANTED)
def test_a_jump_is_told_with_its_place_and_its_end(fault: str, timestep: float | None) -> None:
    arrays, begins, ends = PLANTED[fault]
    found = judged(ONE.scenario, arrays, timestep)
    (words,) = found.explained_by
    assert words.startswith(begins)
    assert words.endswith(ends)
    assert found.is_beyond
