"""The constants of the verdict's protocol, for the report: read from the code that uses them."""

from ....engines.checks.read_back import READ_BACK_SLACK, READ_BACK_SLACK_SINGLE
from ....reference.solution import MAX_UNCERTAINTY
from ....scenarios import EFFECTS
from ...harness import comparison, ladder, step_cost
from ...harness.executors import TIME_LIMIT
from ...harness.judging import best_window, ladder_end, observed_order, signal_ladder
from ...harness.judging.ladder import RUNGS_OF_A_LIMIT
from ...harness.measuring import asymptotic
from ..analysis.wording import count, number


def constants() -> dict[str, str]:
    """Name and printed value of every constant in the text of the protocol."""
    return {
        "rates": " and ".join(e.rate_formula for e in EFFECTS.values() if e.rate_formula),
        "coarsest_turn": number(ladder.COARSEST_TURN),
        "largest_turn": number(ladder.LARGEST_TURN),
        "least_steps": str(ladder.LEAST_STEPS),
        "max_steps": count(ladder.MAX_STEPS),
        "decided_steps": count(ladder.DECIDED_STEPS),
        "min_rungs": str(ladder.MIN_RUNGS),
        "goal": number(ladder_end.GOAL),
        "fine_goal": number(ladder_end.FINE_GOAL),
        "high_order": str(ladder_end.HIGH_ORDER),
        "rungs_of_a_limit": str(RUNGS_OF_A_LIMIT),
        "absurd_energy": f"{comparison.ABSURD_ENERGY:g}",
        "order_slack": f"{asymptotic.ORDER_SLACK:g}",
        "above_uncertainty": f"{observed_order.ABOVE_UNCERTAINTY:g}",
        "asymptotic": f"{asymptotic.ASYMPTOTIC:g}",
        "fitted_rungs": str(observed_order.FITTED_RUNGS),
        "sharp": f"{best_window.SHARP:g}",
        "distinct": f"{asymptotic.DISTINCT:g}",
        "shown_over": str(signal_ladder.SHOWN_OVER),
        "safe": f"{best_window.SAFE:g}",
        "cautious": f"{asymptotic.CAUTIOUS:g}",
        "settling_order": f"{observed_order.SETTLING_ORDER:g}",
        "time_limit": f"{TIME_LIMIT:g}",
        "resolutions": str(step_cost.RESOLUTIONS),
        "stretch_ms": f"{1e3 * step_cost.STRETCH:g}",
        "share_of_call": f"{step_cost.SHARE_OF_CALL:.0%}",
        "repeats": str(step_cost.REPEATS),
        "warm_up": count(step_cost.WARM_UP),
        "timed_turn": number(step_cost.TIMED_TURN),
        "max_uncertainty": number(MAX_UNCERTAINTY),
        "read_back": number(READ_BACK_SLACK),
        "read_back_single": number(READ_BACK_SLACK_SINGLE),
    }
