"""What explains the gains of an engine's steps is named with a number that their noise leaves."""

import numpy as np
from case_loops import each_case
from spincheck.engines.checks.equation_residuals import ASKEW, starting_with
from spincheck.engines.checks.equations import Equations, Gain
from spincheck.engines.checks.explanations import explanation
from spincheck.engines.checks.read_back import start_state
from spincheck.scenarios.rotation import cross
from spincheck.suite.contract_scenes import SCENES

SCENE = SCENES["heavy-tilted"]
SPAN = 1e-6


def explained(left_out: float, noise: float) -> str:
    """The words for a body on a pivot whose engine leaves out so much of the gyroscopic torque.

    Parameters
    ----------
    noise : N m, what any gain may be off
    """
    equations, gains = Equations(SCENE), []
    for way in ASKEW:
        state = start_state(starting_with(SCENE, 4.0 * np.array(way)))
        omega = equations.after(state, SPAN / 2).omega_body
        excess = np.zeros((4, 3))
        excess[1] = left_out * cross(omega, equations.inertia @ omega)
        gains.append(Gain(state, SPAN, excess, np.ones((4, 3))))
    return explanation(equations, gains, np.full((len(gains), 4), noise))


@each_case(
    ("left_out", "noise", "words"),
    {
        "all": (1.0, 1e-6, "there were no gyroscopic torque"),
        "a tenth too much": (1.1, 1e-6, "the gyroscopic torque ω × Iω were -0.1 times as strong"),
        "a tenth, which is noise": (1.1, 0.5, "there were no gyroscopic torque"),
        "a fifth": (0.2, 1e-6, "the gyroscopic torque ω × Iω were 0.8 times as strong"),
    },
)
def test_a_factor_is_whole_within_its_noise(left_out: float, noise: float, words: str) -> None:
    assert explained(left_out, noise) == words


def test_a_factor_that_noise_hides_is_no_number() -> None:
    assert "times as strong" not in explained(0.2, 1.5)
