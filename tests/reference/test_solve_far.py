"""`solve` at times far beyond what the ODE reaches: closed forms still hold."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from library_scenes import library_scene
from mpmath import mp, mpf
from spincheck.reference import solve
from spincheck.reference.closed_forms import ClosedForm, closed_form
from spincheck.reference.problem import Problem
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.solve import CHECKED_TURN, ROUNDING
from spincheck.reference.taylor import IntegrationError, integrate
from taylor_problems import distance
from top_scenes import ASYMMETRIC, HEAVY, TOP, scene
from two_turns import two_turns

pytestmark = pytest.mark.slow

START = "euler_zyz_deg = [10, 50, 20]\nomega_body = [0.4, 0.3, 1.1]"
FREE = ""
#: The stated error may miss the true one by this factor at the most.
HONESTY = 10.0
#: s; of a top of about 1 rad/s, ten thousand times what the ODE is taken to.
FAR = 1e4 * CHECKED_TURN
#: Forty of them are left of a phase at `AGES`.
DIGITS = 60
#: s; where double-doubles no longer hold its phase to an ulp.
AGES = 1e20
#: Relative, of a closed form's rates: far above rounding, and small.
FAULT = 1e-9


def test_what_is_stated_of_a_closed_form_grows_with_the_turns_it_has_made():
    scenario = scene(TOP, START, FREE)
    stated = solve(scenario, np.array([0.0, AGES]))
    q_stated = [mpf(x) for x in stated.trajectory.q_world_body_wxyz[1].tolist()]
    p = rotational_problem(scenario)
    with mp.workdps(DIGITS):
        L = tuple(i * w for i, w in zip(p.moments, p.omega_axes, strict=True))
        q, _ = two_turns(p.moments[0], L, p.q_world_axes, p.omega_axes, 2, mpf(AGES))
        true_error = min(distance([sign * x for x in q_stated], q) for sign in (1, -1))
    assert true_error > HONESTY * ROUNDING
    assert true_error <= HONESTY * stated.uncertainty.attitude


def off_by_a_billionth(problem: Problem) -> ClosedForm | None:
    """A closed form whose rates are wrong by `FAULT`."""
    form = closed_form(problem)
    phases, clock = form.tables.phases.copy(), form.tables.clock.copy()
    phases[:, 0] *= 1 + FAULT
    clock[0] *= 1 + FAULT
    return replace(form, tables=form.tables._replace(phases=phases, clock=clock))


#: `TOP`, struck hanging with 2√(M g l/I1) less a part in 10¹².
NEAR_SEPARATRIX = f"""quaternion_wxyz = [0, 1, 0, 0]
omega_body = [{2 * np.sqrt(5.0) * (1 - 1e-12)}, 0, 0]"""
#: Tables of a scene, and a time that the ODE does not reach, or is lost before.
OUT_OF_REACH = {
    "symmetric": ((TOP, START, FREE), FAR),
    "asymmetric": ((ASYMMETRIC, START, FREE), FAR),
    "beside a separatrix": ((TOP, NEAR_SEPARATRIX, HEAVY), 60.0),
}


@pytest.mark.parametrize("before", [[], [0.0]], ids=["alone", "after the start"])
@pytest.mark.parametrize(("tables", "time"), OUT_OF_REACH.values(), ids=OUT_OF_REACH)
def test_beyond_the_odes_reach_a_right_closed_form_is_certain_and_a_wrong_one_is_not(
    tables, time, before, monkeypatch
):
    stated = solve(scene(*tables), np.array([*before, time]))
    assert stated.uncertainty.attitude <= 2 * ROUNDING
    assert stated.conditioning.attitude > FAULT or time == FAR
    module = import_module("spincheck.reference.solve")
    monkeypatch.setattr(module, "closed_form", off_by_a_billionth)
    wrong = solve(scene(*tables), np.array([*before, time]))
    assert wrong.uncertainty.attitude > FAULT


def test_a_chaotic_motion_is_refused_where_none_of_it_is_known():
    with pytest.raises(IntegrationError, match="not known any more at 1000"):
        solve(library_scene("chaos-beyond-the-horizon"), np.array([1000.0]))


@pytest.mark.parametrize("speed", [1e-9, 1.0])
def test_a_pendulum_is_followed_over_as_many_swings_however_small(speed, monkeypatch):
    module = import_module("spincheck.reference.solve")
    reached = []

    def watched(problem, times, *orders):
        reached.append(times[-1])
        return integrate(problem, times, *orders)

    monkeypatch.setattr(module, "integrate", watched)
    hanging = f"quaternion_wxyz = [0, 1, 0, 0]\nomega_body = [{speed}, 0, 0]"
    solve(scene(TOP, hanging, HEAVY), np.array([0.0, FAR]))
    natural = np.sqrt(10.0 / 2.0)  # √(M g l/I1) of `TOP`
    assert reached
    assert reached == [pytest.approx(CHECKED_TURN / natural)] * len(reached)
