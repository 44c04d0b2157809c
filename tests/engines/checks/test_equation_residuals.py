"""The equation residuals detect and name an engine that simulates another scene."""

import sys

import numpy as np
import pytest
from box import BOX
from planted import (
    HeunSession,
    SingleSession,
    SingleUngyroscopicSession,
    UngyroscopicSession,
)
from spincheck.engines import engines
from spincheck.engines.checks.equation_residuals import equation_residuals, starting_with
from spincheck.scenarios import loads
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

#: What is done to a scene's text, and the words for it when the engine is given that and the
#: comparison is made with the scene as it was.
ANOTHER = [
    ("heavy-tilted", "[1.0, -2.0, -9.0]", "[-1.0, 2.0, 9.0]", "as if gravity were turned round"),
    ("free-falling", "[1.0, -2.0, -9.0]", "[-1.0, 2.0, 9.0]", "as if gravity were turned round"),
    ("heavy-tilted", "mass = 1.3", "mass = 2.6", "I dω/dt, N m in body axes, is"),
    ("free", "[1.0, 2.0, 2.5]", "[2.5, 2.0, 1.0]", "I dω/dt, N m in body axes, is"),
    ("pivot-drag", "rotational = 0.3", "rotational = 0.35", "as if it were slowed by 0.05 N m s"),
    # What a body was set to is read back before; its equations are the same.
    ("free", "-2.0", "-2.5", ""),
    ("free-thrown", "velocity = [0.2", "velocity = [0.25", ""),
]


@pytest.mark.parametrize(("name", "old", "new", "words"), ANOTHER)
def test_an_engine_with_another_scene_in_it_begins_otherwise(
    name: str, old: str, new: str, words: str
) -> None:
    mujoco = engines()["mujoco"]
    text = SCENES[name].text
    assert old in text
    other = loads(text.replace(old, new), name)
    residuals = equation_residuals(
        lambda scene, h: mujoco.open(
            starting_with(other, scene.start.omega_body), mujoco.method("RK4"), h
        ),
        SCENES[name],
    )
    assert words in residuals
    assert bool(residuals) == bool(words)


#: Changes of a ten-thousandth: a scene, what is done to its text, and how it is named.
SMALL = [
    (
        "heavy-tilted",
        "[1.0, -2.0, -9.0]",
        "[1.0001, -2.0002, -9.0009]",
        "gravity were 1.0001 times",
    ),
    (
        "free-falling",
        "[1.0, -2.0, -9.0]",
        "[1.0001, -2.0002, -9.0009]",
        "gravity were 1.0001 times",
    ),
    (
        "heavy-tilted",
        "[1.0, -2.0, -9.0]",
        "[1.001, -2.0, -9.0]",
        "gravity were [1.00",
    ),
    ("free", "[1.0, 2.0, 2.5]", "[1.0001, 2.0, 2.5]", "the moments were ["),
    ("pivot-drag", "rotational = 0.3", "rotational = 0.30003", "it were slowed by 3e-05 N m s"),
]


@pytest.mark.parametrize(("name", "old", "new", "words"), SMALL)
def test_a_change_of_a_ten_thousandth_is_named(name: str, old: str, new: str, words: str) -> None:
    test_an_engine_with_another_scene_in_it_begins_otherwise(name, old, new, f"as if {words}")


ALONG_AN_AXIS = loads(BOX.replace("[1.0, 2.0, 0.5]", "[0.0, 0.0, 3.0]"), "along-an-axis")


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
@pytest.mark.parametrize("scene", [loads(BOX, "box"), ALONG_AN_AXIS], ids=lambda scene: scene.name)
def test_a_missing_gyroscopic_torque_is_named_whatever_the_start(scene, single) -> None:
    session = SingleUngyroscopicSession if single else UngyroscopicSession
    residuals = equation_residuals(session, scene, is_single=single)
    assert "as if there were no gyroscopic torque" in residuals


@pytest.mark.parametrize("size", [1e-4, 1e-2])
def test_a_clock_that_is_off_is_named_with_its_number(size: float) -> None:
    residuals = equation_residuals(lambda s, h: HeunSession(s, (1 - size) * h), loads(BOX, "box"))
    assert f"as if a step took {1 - size:.7g} timesteps: dR/dt" in residuals


def test_a_faultless_engine_in_single_precision_begins_as_the_scene_does() -> None:
    assert equation_residuals(SingleSession, loads(BOX, "box"), is_single=True) == ""


#: s, below which it sticks.
STICKS = 0.0


class StickingSession(HeunSession):
    """Turns by a ten-thousandth less about x at timesteps below `STICKS`."""

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            super().advance(1)
            if self.timestep < STICKS:
                self.turn(np.array([-1e-4 * self.timestep, 0.0, 0.0]))


@pytest.mark.parametrize(("share", "begins"), [(1.5, ""), (1e9, "dR/dt")], ids=["one", "all"])
def test_an_error_in_the_shortest_of_the_timesteps_alone_is_noise(
    monkeypatch: pytest.MonkeyPatch, share: float, begins: str
) -> None:
    """Such as of an engine that drops turns below some size; in all of them it is none."""
    opened: list[float] = []

    def open_at(scene, timestep):
        opened.append(timestep)
        return StickingSession(scene, timestep)

    monkeypatch.setattr(sys.modules[__name__], "STICKS", 0.0)
    equation_residuals(open_at, loads(BOX, "box"))
    monkeypatch.setattr(sys.modules[__name__], "STICKS", share * min(opened))
    residuals = equation_residuals(StickingSession, loads(BOX, "box"))
    assert residuals[:5] == begins
