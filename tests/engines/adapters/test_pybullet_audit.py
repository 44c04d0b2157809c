"""The audit detects torques, gravity and shapes that the scene does not call for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from pybullet_planted import (
    BY_CONSTRAINT,
    MAXIMAL,
    METHODS,
    MULTIBODY,
    TIMESTEP,
    change,
    leave_out,
    opened,
    rotor,
    run,
    skip,
)
from spincheck.engines import Method
from spincheck.engines.adapters.pybullet import load as pybullet_load
from spincheck.engines.adapters.pybullet import session as pybullet_session
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES

Plant = Callable[[pytest.MonkeyPatch], None]


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


@pytest.mark.parametrize("method", [MULTIBODY, MAXIMAL], ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["free-torque-body", "free-drag"])
def test_a_torque_that_turns_must_be_renewed_every_step(name: str, method: Method) -> None:
    def after(at_once: bool) -> np.ndarray:
        with opened(SCENES[name], method) as session:
            session.world.at_once = at_once
            session.advance(64)
            return session.read_state().omega_body

    assert np.abs(after(at_once=True) - after(at_once=False)).max() > TIMESTEP**2


# Faults in what the adapter asks of PyBullet


def in_the_model(old: str, new: str) -> Plant:
    """Another text of the model."""
    real = pybullet_load.urdf

    def plant(patch: pytest.MonkeyPatch) -> None:
        def written(scenario: Scenario, **keywords: object) -> str:
            assert old in real(scenario, **keywords)
            return real(scenario, **keywords).replace(old, new)

        patch.setattr(pybullet_load, "urdf", written)

    return plant


def heavy(patch: pytest.MonkeyPatch) -> None:
    real = p.setGravity
    patch.setattr(p, "setGravity", lambda x, y, z, **keywords: real(x, y, z - 9.81, **keywords))


def along_the_body(patch: pytest.MonkeyPatch) -> None:
    """A joint's ω along the body's axes, not along its principal ones."""
    real, omega = p.resetJointStateMultiDof, SCENES["pivot"].start.omega_body

    def reset(body: int, link: int, q: object, _: object, **named: object) -> None:
        real(body, link, q, omega, **named)

    patch.setattr(p, "resetJointStateMultiDof", reset)


SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
#: What is planted, in which scene and methods, and in what words the run fails.
FAULTS: dict[str, tuple[Plant, Scenario, list[Method], str]] = {
    "default damping": (
        lambda patch: leave_out(patch, "changeDynamics", "linearDamping", "angularDamping"),
        *(rotor(10.0), [MULTIBODY, BY_CONSTRAINT], "a resistance of"),
    ),
    "default damping of the com": (
        lambda patch: leave_out(patch, "changeDynamics", "linearDamping"),
        *(SCENES["free-thrown"], [MULTIBODY], "a force of"),
    ),
    "the default motor": (
        lambda patch: skip(patch, "setJointMotorControlMultiDof"),
        *(rotor(10.0), [MULTIBODY], "a resistance of"),
    ),
    "a torque along other axes": (
        lambda patch: patch.setattr(p, "LINK_FRAME", p.WORLD_FRAME),
        *(SCENES["free-torque-body"], [MULTIBODY], "a torque of"),
    ),
    "gravity": (heavy, SCENES["pivot"], METHODS, "a gravity of [0.0, 0.0, -9.81] m/s²"),
    "a shape to collide with": (
        in_the_model('<link name="top">', '<link name="top">' + SHAPE),
        *(SCENES["pivot"], METHODS, "a collision shape"),
    ),
    "no inertia from the file": (
        lambda patch: change(patch, "loadURDF", flags=0),
        *(SCENES["free-tilted"], [MULTIBODY, MAXIMAL], "'inertia_com' must read back as"),
    ),
    "what is warned of": (
        in_the_model("<axis", "<no-axis"),
        *(SCENES["pivot"], [MULTIBODY], "PyBullet warns; PyBullet printed: b3Warning"),
    ),
    "what does not load": (
        in_the_model("</robot>", ""),
        *(SCENES["free"], [MULTIBODY], "PyBullet cannot load the body"),
    ),
    "a velocity along the body": (
        along_the_body,
        *(SCENES["pivot"], [MULTIBODY], "'omega_body' must read back as"),
    ),
}


@each_case(("plant", "scenario", "methods", "words"), FAULTS)
def test_a_planted_fault_fails_the_run(
    plant: Plant, scenario: Scenario, methods: list[Method], words: str
) -> None:
    for method in methods:
        with pytest.MonkeyPatch.context() as patch:
            plant(patch)
            result = run(scenario, method)
        assert result.outcome == "failed", method.name
        assert words in result.reason, result.reason
