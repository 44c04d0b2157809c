"""Faults of a child engine fail its run with a cause; a faultless child gives ordinary runs."""

import pickle
import sys
from pathlib import Path

import numpy as np
import psutil
import pytest
from case_loops import each_case
from spincheck.engines import EngineError, Run
from spincheck.engines.child import ChildEngine, ProtocolError, child_engine, process
from spincheck.engines.child.messages import Hello, Misanswer, parse
from spincheck.engines.child.process import end_idle
from spincheck.suite import test_adapter
from spincheck.suite.contract_scenes import scene

pytestmark = pytest.mark.processes

PLANTED = Path(__file__).with_name("planted_child.py")
SPHERE = scene("sphere", body="\nmass = 2.0\ninertia = [0.3, 0.3, 0.3]\n")
STEPS = np.arange(0, 65, 8)
TIMESTEP = 2.0**-6
#: s; more than a child takes to answer on a busy machine, less than a test may take.
LIMIT = 2.0


@pytest.fixture(autouse=True)
def _nobody_left():
    yield
    end_idle()


def planted(fault: str = "") -> ChildEngine:
    return child_engine([sys.executable, "-S", str(PLANTED), fault], LIMIT)


def ran(engine: ChildEngine) -> Run:
    (method,) = engine.methods
    return engine.run(SPHERE, method, TIMESTEP, STEPS)


@pytest.mark.parametrize("manner", ["", "chats"])
def test_an_honest_child_is_an_engine_like_any_other_in_a_worker_too(manner: str) -> None:
    run = ran(pickle.loads(pickle.dumps(planted(manner))))
    assert (run.outcome, run.reason) == ("ok", "")
    assert run.trajectory is not None
    start = SPHERE.start.omega_body
    # Read back through two rotations.
    slack = 8 * np.finfo(float).eps * np.linalg.norm(start)
    assert np.abs(run.trajectory.omega_body - start).max() <= slack


FAULTS = {
    "dies": ("crash", "ended with exit code 3 instead of answering 'run'; it last printed: assert"),
    "dies in node": ("crash", "it last printed: Error: Cannot find module 'nowhere.mjs'"),
    "crashes": ("crash", "was killed by SIGSEGV"),
    "hangs": ("time-out", "did not answer 'run' within 2 s"),
    "answers to standard output": ("time-out", "answers go to the descriptor in SPINCHECK_ANSWERS"),
    "prints garbage": ("protocol", "its answer to 'run' is not JSON: 'Hello from the physics"),
    "never ends a line": ("protocol", "is longer than 1048576 bytes"),
    "closes its pipe": ("protocol", "closed its pipe"),
    "speaks unasked": ("protocol", "must have the call's 'id'"),
    "another's answer": ("protocol", "must have the call's 'id'"),
    "three of four": ("protocol", "breaks the protocol at 'q"),
    "a spin too many": ("protocol", "'spins' must have one entry a part, 0, got 1"),
    "a part too many": ("protocol", "'body.parts' must have one entry a part, 0, got 1"),
    "text for numbers": ("protocol", "breaks the protocol at 'com"),
    "one key more": ("protocol", "breaks the protocol at 'energy'"),
    "NaN": ("protocol", "null says that a number is not finite"),
    "heavier": ("read-back", "'mass' must read back as 2.0, got 2.02"),
    "confesses": ("model", "wind"),
    # The motion's.
    "no number": ("not-finite", ""),
    "refuses": ("warning", "the solver will not\\x1b[2J"),
    # Somebody else is to blame.
    "killed by SIGKILL": ("killed", "was killed from outside by SIGKILL instead of answering"),
    "killed by SIGSTOP": ("environment", "stopped from outside"),
}


@each_case(("fault", "cause", "words"), [(fault, *told) for fault, told in FAULTS.items()])
def test_a_child_that_misbehaves_costs_its_run_and_is_reported_by_name(
    fault: str, cause: str, words: str
) -> None:
    run = ran(planted(fault))
    outcome = "diverged" if cause in ("not-finite", "warning") else "failed"
    assert (run.outcome, run.cause) == (outcome, cause)
    assert words in run.reason


def test_a_child_that_restarts_keeps_the_contract() -> None:
    engine = planted()
    with engine.open(SPHERE, engine.methods[0], TIMESTEP) as session:
        assert session.can_restart
    for fault, words in {
        "restarts with its old spin": "restarted, 'omega_body' must read back",
        "restarts late": "restarted twice it moves in two ways",
    }.items():
        with pytest.raises(pytest.fail.Exception, match=words):
            test_adapter.test_restarts_as_it_opens(planted(fault), engine.methods[0])


def test_a_child_that_is_another_each_time_is_not_opened() -> None:
    engine = planted("changes its name")
    end_idle()
    run = ran(engine)
    assert (run.outcome, run.cause) == ("failed", "protocol")
    assert "engine, version or methods are not those" in run.reason


HELLO = (
    '{"id": 1, "protocol": 1, "name": "n", "version": "1", "precision": "double", '
    '"stock_timestep": 0.01, "methods": [{"name": "m", "order": 1, "attitude_order": 1, '
    '"summary": "s", "effects": []}]}'
)


@each_case(
    ("said", "instead", "words"),
    [
        *(
            ("0.01", seconds, "breaks the protocol at 'stock_timestep'")
            for seconds in ("1e300", "1e400", "0.0", "-1.0")
        ),
        ('"protocol": 1', '"protocol": 2', "'protocol' must be 1, got 2: it needs a newer spin"),
        # A later version may have keys that this one does not know.
        ('"protocol": 1', '"protocol": 2, "batch": 3', "it needs a newer spincheck"),
    ],
)
def test_a_description_that_breaks_the_protocol_is_refused(
    said: str, instead: str, words: str
) -> None:
    assert isinstance(parse(HELLO.encode(), 1, Hello), Hello)
    with pytest.raises(Misanswer, match=words):
        parse(HELLO.replace(said, instead).encode(), 1, Hello)


def test_an_answer_with_a_key_twice_is_refused() -> None:
    """Which of the two values holds depends on who reads it."""
    line = HELLO.replace('"version"', '"version": "0.9", "version"')
    assert line != HELLO
    with pytest.raises(Misanswer, match="has the key 'version' twice"):
        parse(line.encode(), 1, Hello)


def test_a_child_that_died_leaves_the_next_run_a_new_one() -> None:
    engine = planted("dies")
    reasons = {ran(engine).reason for _ in range(2)}
    assert len(reasons) == 1
    assert "exit code 3" in reasons.pop()


def test_a_child_that_earlier_scenes_have_left_without_memory_is_replaced() -> None:
    engine = planted("frees nothing")
    assert {ran(engine).outcome for _ in range(5)} == {"ok"}


def test_a_child_killed_while_it_was_idle_is_replaced() -> None:
    engine = planted()
    (child,) = process._idle[engine.command]
    psutil.Process(child.pid).kill()
    psutil.wait_procs([psutil.Process(child.pid)], timeout=10)
    assert ran(engine).outcome == "ok"


def test_times_are_the_childs_own_unless_they_are_impossible() -> None:
    (method,) = planted().methods
    with planted().open(SPHERE, method, TIMESTEP) as session:
        cpu, wall = session.timed(1)
        assert 0 < cpu == wall < LIMIT
    with (
        planted("faster than time").open(SPHERE, method, TIMESTEP) as session,
        pytest.raises(EngineError, match="took 1e\\+06 s, of"),
    ):
        session.timed(1)


def test_two_scenes_at_once_are_in_two_children() -> None:
    engine = planted()
    (method,) = engine.methods
    with engine.open(SPHERE, method, TIMESTEP) as first:
        with engine.open(SPHERE, method, TIMESTEP) as second:
            second.advance(8)
            moved = second.read_state().q_world_body_wxyz
        assert np.abs(first.read_state().q_world_body_wxyz - moved).max() > TIMESTEP


def test_what_the_command_names_counts_as_the_engines_sources() -> None:
    assert PLANTED in planted().sources


def test_a_command_that_is_none_is_reported() -> None:
    with pytest.raises(ProtocolError, match="'no-such-engine' cannot be started"):
        child_engine(["no-such-engine"])
