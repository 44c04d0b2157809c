"""The torques of a scene that no element of a PyBullet model gives."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pybullet as p

from ....scenarios import Scenario
from .model import BASE, Model


def torques(model: Model, scenario: Scenario) -> tuple[list[Callable[[], None]], bool]:
    """What to apply before a call, and whether that call may take many steps.

    PyBullet applies a torque in all steps of a call and clears it afterwards. A torque constant in
    world axes, or on a joint, is right for all of them; any other must be set again every step.
    """
    applied: list[Callable[[], None]] = []
    at_once, pushed = True, scenario.pushed
    if pushed["torque_world"].any():
        applied.append(partial(_push, model, pushed["torque_world"].tolist(), p.WORLD_FRAME))
    if pushed["torque_body"].any():
        axes_from_body = model.body_from_principal.inv()
        principal = axes_from_body.apply(np.array(pushed["torque_body"])).tolist()
        if model.link == BASE:
            applied.append(partial(_push, model, principal, p.LINK_FRAME))
            at_once = False
        else:
            applied.append(partial(_push_joint, model, principal))
    if drag := pushed["drag"]:
        at_once = False
        if model.link == BASE:
            applied.append(partial(_drag, model, drag))
        else:
            p.changeDynamics(
                model.body, model.link, jointDamping=drag, physicsClientId=model.client
            )
    return applied, at_once


def _push(model: Model, torque: list[float], frame: int) -> None:
    p.applyExternalTorque(model.body, model.link, torque, frame, model.client)


def _push_joint(model: Model, torque_principal: list[float]) -> None:
    p.setJointMotorControlMultiDof(
        model.body,
        model.link,
        p.TORQUE_CONTROL,
        force=torque_principal,
        physicsClientId=model.client,
    )


def _drag(model: Model, coefficient: float) -> None:
    _, (x, y, z) = p.getBaseVelocity(model.body, model.client)
    torque = (-coefficient * x, -coefficient * y, -coefficient * z)
    p.applyExternalTorque(model.body, model.link, torque, p.WORLD_FRAME, model.client)
