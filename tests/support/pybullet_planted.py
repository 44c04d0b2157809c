"""Faults to plant in what the adapter asks of PyBullet, and scenes in which they show."""

from typing import Any

import numpy as np
import pybullet as p
import pytest
from spincheck.engines import Method, Run
from spincheck.engines.adapters.pybullet.engine import REPRESENTATIONS, PyBullet
from spincheck.engines.adapters.pybullet.session import PyBulletSession
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import PIVOT, scene

ENGINE = PyBullet()
#: Of bodies that are free or on a pivot.
METHODS = [m for m in ENGINE.methods if not m.as_shipped and "table" not in m.requires]
MULTIBODY, BY_CONSTRAINT, MAXIMAL = METHODS
TIMESTEP = 1e-3
STEPS = np.arange(0, 51, 10)

#: Spins about an axis that stays: ω must not change at all.
ROTOR = """
mass = 1.0
inertia = [1.0, 2.0, 2.5]
com = [0.0, 0.0, 0.3]
"""
ALONG_Z = """
quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, {spin}]
"""


def rotor(spin: float, effects: str = PIVOT) -> Scenario:
    return scene("rotor", body=ROTOR, start=ALONG_Z.format(spin=spin), effects=effects)


def run(scenario: Scenario, method: Method) -> Run:
    return ENGINE.run(scenario, method, TIMESTEP, STEPS)


def opened(scenario: Scenario, method: Method, timestep: float = TIMESTEP) -> PyBulletSession:
    return PyBulletSession(scenario, REPRESENTATIONS[method.name], timestep)


def leave_out(monkeypatch: pytest.MonkeyPatch, function: str, *keywords: str) -> None:
    """Call one of PyBullet's functions without some of the arguments it is given."""
    real = getattr(p, function)

    def called(*args: Any, **arguments: Any) -> Any:
        return real(*args, **{k: v for k, v in arguments.items() if k not in keywords})

    monkeypatch.setattr(p, function, called)


def change(monkeypatch: pytest.MonkeyPatch, function: str, **keywords: Any) -> None:
    """Call one of PyBullet's functions with other arguments than it is given."""
    real = getattr(p, function)
    monkeypatch.setattr(
        p, function, lambda *args, **arguments: real(*args, **{**arguments, **keywords})
    )


def skip(monkeypatch: pytest.MonkeyPatch, function: str) -> None:
    """Do not call one of PyBullet's functions at all."""
    monkeypatch.setattr(p, function, lambda *_, **__: None)
