"""The first steps of every engine obey the scene's equations; of a scene that is another, not."""

import numpy as np
import pytest
from scenes import SCENES
from spincheck.engines import Engine, Method, engines
from spincheck.engines.first_steps import equation_residuals
from spincheck.scenarios import loads

METHODS = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine in engines().values()
    for method in engine.methods
    if not method.as_shipped
]
EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_an_engine_begins_as_the_scene_does(engine: Engine, method: Method, name: str) -> None:
    assert engine.equation_residuals(SCENES[name], method) == ""


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
    said = equation_residuals(
        lambda h: mujoco.open(other, mujoco.method("RK4"), h), SCENES[name], EPS
    )
    assert words in "; ".join(said)
    assert bool(said) == bool(words)
