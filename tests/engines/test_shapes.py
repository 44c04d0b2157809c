"""Arrays of another shape than a body or a state has are named, with class and method."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from interface_1.free_body.toy_engine import Toy, ToySession
from spincheck.engines import Run
from spincheck.reports.harness.gradients.study import gradients_of
from spincheck.suite.contract_scenes import SCENES

SAMPLES = np.arange(5)
SCENE, WITH_ROTORS = SCENES["free"], SCENES["free-rotors"]


def toy_of(members: dict[str, Any]) -> Toy:
    """The toy with other members of its session."""
    session = type("OtherSession", (ToySession,), members)
    return type("Other", (Toy,), {"open": lambda _, scene, __, h: session(scene, h)})()


def run_of(members: dict[str, Any]) -> Run:
    return toy_of(members).run(SCENE, Toy.methods[0], 0.01, SAMPLES)


def state(**others: object) -> dict[str, Any]:
    """Arrays that are read otherwise."""
    return {"read_state": lambda self: replace(ToySession.read_state(self), **others)}


def body(**others: object) -> dict[str, Any]:
    return {"read_body": lambda self: replace(self.held, **others)}


def states(change: Callable[[Sequence[Any]], Sequence[Any]]) -> dict[str, Any]:
    """Other snapshots, of which states are made."""
    return {"states": lambda self, snapshots: ToySession.states(self, change(snapshots))}


#: By what is said: how the toy's session is changed.
WRONG = {
    "'omega_body' of OtherSession.read_state must be an array of shape (3,), got (4,)": state(
        omega_body=np.ones(4)
    ),
    "'q_world_body_wxyz' of OtherSession.read_state must be an array of shape (4,), got (3,)": (
        state(q_world_body_wxyz=np.ones(3))
    ),
    "'com_world' of OtherSession.read_state must be an array of shape (3,), got (1, 3)": state(
        com_world=np.ones((1, 3))
    ),
    "'spins' of OtherSession.read_state must be an array of shape (0,), got (2,)": state(
        spins=np.ones(2)
    ),
    "'omega_body' of OtherSession.read_state must be an array of shape (3,), got [1.0, 2.0, 3.0]": (
        state(omega_body=[1.0, 2.0, 3.0])
    ),
    "OtherSession.read_state must return a State, got 3": {"read_state": lambda _: 3},
    "'com' of OtherSession.read_body must be an array of shape (3,), got (4,)": body(
        com=np.ones(4)
    ),
    "'inertia_com' of OtherSession.read_body must be an array of shape (3, 3), got (3,)": body(
        inertia_com=np.ones(3)
    ),
    "'q_world_body_wxyz' of OtherSession.states must be an array of shape (5, 4), got (4, 4)": (
        states(lambda snapshots: snapshots[1:])
    ),
    "'q_world_body_wxyz' of OtherSession.states must be an array of shape (5, 4), got (6, 4)": (
        states(lambda snapshots: [*snapshots, snapshots[0]])
    ),
}


@each_case(("words", "members"), [*WRONG.items()])
def test_a_run_fails_and_says_what_returned_which_shape(
    words: str, members: dict[str, Any]
) -> None:
    run = run_of(members)
    assert (run.outcome, run.cause, run.reason) == ("failed", "bug", words)


def test_shapes_that_are_right_pass() -> None:
    assert run_of({}).outcome == "ok"


def test_a_scene_with_rotors_needs_a_spin_and_an_axial_moment_of_each() -> None:
    able = replace(Toy.methods[0], effects=WITH_ROTORS.called_for)
    run = toy_of({}).run(WITH_ROTORS, able, 0.01, SAMPLES)
    count = len(WITH_ROTORS.rotors.each)
    words = f"'axial' of OtherSession.read_body must be an array of shape ({count}, 3), got (0, 3)"
    assert (run.outcome, run.reason) == ("failed", words)


@pytest.mark.slow
def test_derivatives_are_not_taken_of_a_state_of_another_shape() -> None:
    (row,) = gradients_of(SCENE, toy_of(state(omega_body=np.ones(4))), "RK4")
    words = "'omega_body' of OtherSession.read_state must be an array of shape (3,), got (4,)"
    assert (row.judged.verdict, row.judged.reason) == ("failed", words)
