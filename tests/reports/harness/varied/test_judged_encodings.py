"""What is said of a body that is described otherwise: which description is the nearer, and of rest.

Not verified here: that encodings mean the same (`tests/engines/test_encodings.py`).
"""

from dataclasses import replace

import numpy as np
from case_loops import each_case
from failing_calls import FailingCalls
from spincheck.engines import engines
from spincheck.engines.checks.read_back import State
from spincheck.engines.encodings import ENCODINGS, SceneChange
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.varied.encodings import run_encodings
from spincheck.reports.results.records import Row
from spincheck.reports.results.store import open_store
from spincheck.scenarios import FloatArray, Scenario, loads
from studies import Nowhere

EPS = float(np.finfo(float).eps)
#: s.
TIMESTEP = 2.0**-9
NEARER = "nearer to the exact motion"
#: With its com off the frame's origin: MuJoCo moves the origin, and the com drifts.
SCENE = """spincheck = 1
title = "A body, its frame off the com"
source = "made up"
[body]
mass = 0.5
inertia = [1e-3, 2e-3, 2.5e-3]
com = [0.0, 0.02, 0.0]
[start]
rotation_vector_deg = [24.0, 0.0, 32.0]
omega_body = {omega}
[window]
duration = 0.5
samples = 5
"""


def scene(omega: list[float]) -> Scenario:
    return loads(SCENE.format(omega=omega), "off-its-com")


def answers(scenario: Scenario, method: str, *names: str) -> dict[str, Row]:
    choice = Choice((engines()["mujoco"],), methods=(method,), timesteps=(TIMESTEP,))
    with InProcess() as executor:
        rows = run_encodings([scenario], choice, names, Nowhere(), executor)
    return {row.encoding: row for row in rows}


@each_case("method", ["RK4", "Euler"])
def test_where_the_scenes_own_description_drifts_that_is_said(method: str) -> None:
    made = answers(scene([0.3, 12.0, 0.5]), method, "aligned", "offset")
    aligned, offset = made["aligned"], made["offset"]
    assert (aligned.beside.word, offset.beside.word) == ("coarser", "coarser")
    assert aligned.errors.com < aligned.beside.apart.com / 100
    assert NEARER in aligned.beside.reason
    # Planted: a frame that is farther off drifts more.
    assert offset.errors.com > aligned.beside.apart.com
    assert NEARER not in offset.beside.reason


def test_a_body_at_rest_is_the_same_however_it_is_described(monkeypatch) -> None:
    """No velocity to be relative to: distances are 0, or infinite. Boosted, it is not at rest."""
    at_rest, right = scene([0.0, 0.0, 0.0]), SceneChange.state_back
    names = [name for name in ENCODINGS if name not in ("plain", "boosted")]
    made = answers(at_rest, "Euler", *names)
    assert {name for name, one in made.items() if one.beside.word != "same"} == set()

    def creeping(change: SceneChange, states: State, times: FloatArray) -> State:
        back = right(change, states, times)
        moved = change.q_body_new != SceneChange().q_body_new
        return replace(back, velocity_world=back.velocity_world + moved * EPS)

    monkeypatch.setattr(SceneChange, "state_back", creeping)
    assert answers(at_rest, "Euler", "turned")["turned"].beside.word != "same"


def test_what_is_stored_is_not_run_again_unless_that_is_asked_for(path) -> None:
    choice = Choice((engines()["mujoco"],), methods=("RK4",), timesteps=(TIMESTEP,))
    tumbling = scene([0.3, 12.0, 0.5])
    with open_store(path, create=True) as store, InProcess() as executor:
        (first,) = run_encodings([tumbling], choice, ["offset"], store, executor)
        simulated = FailingCalls()
        (stored,) = run_encodings([tumbling], choice, ["offset"], store, simulated)
        assert vars(stored) == vars(first)
        # The exact motion alone.
        assert simulated.calls == 1
        again = replace(choice, again=True)
        run_encodings([tumbling], again, ["offset"], store, simulated)
        assert simulated.calls > 3
        assert len(store.varied(tumbling.name)) == 1
