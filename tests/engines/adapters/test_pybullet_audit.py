"""The audit detects torques, gravity and shapes that the scene does not call for."""

from dataclasses import replace

import numpy as np
import pybullet as p
import pytest
from pybullet_planted import (
    MAXIMAL,
    METHODS,
    MULTIBODY,
    TIMESTEP,
    opened,
    run,
)
from spincheck.engines import Method
from spincheck.engines.adapters.pybullet import load as pybullet_load
from spincheck.engines.adapters.pybullet import session as pybullet_session
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps


# Torques


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["pivot-torque-body", "pivot-torque-world", "pivot-drag"])
def test_the_audit_feels_a_torque_that_is_not_applied(name: str, method: Method) -> None:
    scenario = SCENES[name]
    with opened(scenario, method) as session:
        assert session.active() == scenario.called_for
    (missing,) = scenario.called_for - {"pivot"}
    without = replace(scenario, document=SCENES["pivot"].document)
    with opened(without, method) as session:
        assert missing not in pybullet_session.what_acts(session.advance, session.model, scenario)


def test_the_audit_feels_a_torque_along_the_wrong_axes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(p, "LINK_FRAME", p.WORLD_FRAME)
    result = run(SCENES["free-torque-body"], MULTIBODY)
    assert result.outcome == "failed"
    assert "a torque of" in result.reason


@pytest.mark.parametrize("method", [MULTIBODY, MAXIMAL], ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["free-torque-body", "free-drag"])
def test_a_torque_that_turns_must_be_renewed_every_step(name: str, method: Method) -> None:
    def after(at_once: bool) -> np.ndarray:
        with opened(SCENES[name], method) as session:
            session.world.at_once = at_once
            session.advance(64)
            return session.read_state().omega_body

    assert np.abs(after(at_once=True) - after(at_once=False)).max() > TIMESTEP**2


# Extras


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_gravity_that_the_scene_does_not_call_for_fails_the_audit(
    method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = p.setGravity
    monkeypatch.setattr(
        p, "setGravity", lambda x, y, z, **keywords: real(x, y, z - 9.81, **keywords)
    )
    result = run(SCENES["pivot"], method)
    assert result.outcome == "failed"
    assert "a gravity of [0.0, 0.0, -9.81] m/s²" in result.reason


SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_shape_to_collide_with_fails_the_audit(
    method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = pybullet_load.urdf
    monkeypatch.setattr(
        pybullet_load,
        "urdf",
        lambda scenario, **keywords: real(scenario, **keywords).replace(
            '<link name="top">', '<link name="top">' + SHAPE
        ),
    )
    result = run(SCENES["pivot"], method)
    assert result.outcome == "failed"
    assert "a collision shape" in result.reason
