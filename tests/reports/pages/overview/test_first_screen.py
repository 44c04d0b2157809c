"""The first screen's answer, the table's data, and the best choice, from made-up runs."""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from made_up import SECONDS_PER_STEP, SIZE, TIMESTEPS, MadeUp, results
from markdown_text import markdown_tables, plain
from spincheck.reports.pages.analysis.best_choice import ATTITUDE_WITHIN, best_choice
from spincheck.reports.pages.analysis.report_data import ReportData, report_data
from spincheck.reports.pages.analysis.wording import NOTHING, number
from spincheck.reports.pages.overview.first_screen import answer
from spincheck.reports.pages.overview.heat_map import heat_map, stock_table
from spincheck.reports.pages.render import render
from spincheck.reports.results.cost_records import MethodCost, StepCost
from spincheck.reports.results.default_records import DefaultEffect, DefaultEffects
from spincheck.reports.results.records import Key, Row, variation
from spincheck.reports.results.results import Results
from spincheck.reports.results.verdict_words import VERDICT
from spincheck.scenarios import EVERYWHERE, Errors

STOCK = TIMESTEPS[1]
SHIPPED = MadeUp("mujoco", "default", 1)
CLEAN = MadeUp("mujoco", "Euler", 1)
SHARP = MadeUp("mujoco", "RK4", 4)
DYING = MadeUp("pybullet", "default", 1, "diverges", "the state is no longer finite")
EXACT = Errors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
TRIED = (SHIPPED, CLEAN, SHARP, DYING)
UNASKED = ("a force of 0.5 N at 0.1 m/s", "damping", "joint motor")


def stocked(**changed) -> Results:
    """Two scenes and one not solved; the second rung is at the stock timestep of all engines."""
    stored = results(methods=TRIED)
    shipped = {("mujoco", "default"), ("pybullet", "default")}
    return replace(
        stored,
        rows=[_at_stock(row) for row in stored.rows],
        verdicts=[
            replace(v, as_shipped=(v.key.engine, v.key.method) in shipped) for v in stored.verdicts
        ],
        methods={
            pair: replace(method, as_shipped=pair in shipped)
            for pair, method in stored.methods.items()
        },
        **changed,
    )


def _at_stock(row: Row) -> Row:
    row = replace(row, stock=row.timestep == STOCK)
    return replace(row, unasked=UNASKED) if row.key.engine == "pybullet" else row


def taken_away(name: str, acts: bool | None) -> DefaultEffects:
    """What was measured of one default of PyBullet; without any it is exact."""
    effect = DefaultEffect(name, EXACT, EXACT, acts)
    key = Key("made-up-top", "pybullet", "default")
    return DefaultEffects(key, STOCK, EXACT, None, (effect,))


@pytest.fixture(scope="module")
def gathered() -> ReportData:
    return report_data(stocked())


def answered(changed: Callable[[Row], Row]):
    """The answer on the same runs, each changed."""
    stored = stocked()
    return answer(report_data(replace(stored, rows=list(map(changed, stored.rows)))))


def scene(gathered: ReportData, name: str = "made-up-top"):
    return next(scene for scene in gathered.scenes if scene.name == name)


def cell(gathered: ReportData, method: str, engine: str = "mujoco") -> list:
    drawn = heat_map(gathered)
    columns = [(c["engine"], c["method"]) for c in drawn["columns"]]
    carried = next(s for s in drawn["scenes"] if s["name"] == "made-up-top")
    return carried["cells"][columns.index((engine, method))]


def shown(found, method: str) -> dict[str, str]:
    """A column of the answer's table, by measure."""
    column = found["table"].headings.index(method)
    cells = {row[0].text: row[column] for row in found["table"].rows}
    return {measure: f"{cell.text} {cell.detail}".strip() for measure, cell in cells.items()}


def test_the_defaults_are_reported_with_their_size_in_degrees_unless_they_blow_up(gathered):
    # An error of first order, halved once.
    degrees = f"{math.degrees(SIZE[1] / 2):.1f}°"
    found = answer(gathered)
    assert f"mujoco default {degrees}" in found["lead"]
    assert "medians of 2 scenes" in found["about"]
    default = shown(found, "mujoco default")
    assert (default["timestep"], default["largest error"]) == ("10 ms", degrees)
    assert "pybullet default lost on 2 of 2 scenes" in found["lead"]
    assert shown(found, "pybullet default")["on the worst scene"] == "∞ 2 runs blew up"
    # Without engines as shipped there is nothing to answer.
    assert answer(report_data(results())) is None


def test_the_most_accurate_method_of_the_engine_is_offered_with_its_price(gathered):
    """That of its steps, beside that of changing the method alone; without times none."""
    instead = shown(answer(gathered), "use mujoco RK4")
    assert (instead["timestep"], instead["pruned"]) == ("10 ms", "1.0")
    assert "CPU time of a step" not in instead
    unpruned = left_out("clock", unpruned=4 * SECONDS_PER_STEP)
    instead = shown(answer(gathered, [unpruned]), "use mujoco RK4")
    assert instead["CPU time of a step"] == "4.0"
    assert instead["pruned"] == "1.0"

    def slower(row: Row) -> Row:
        is_slower = row.key.method == "RK4" and row.seconds_per_step
        factor = 3 if row.key.scenario == "made-up-brick" else 5
        return replace(row, seconds_per_step=factor * SECONDS_PER_STEP) if is_slower else row

    assert shown(answered(slower), "use mujoco RK4")["pruned"] == "4.0 (3.5 to 4.5)"
    untimed = answered(lambda row: replace(row, seconds_per_step=None))
    assert "CPU" not in untimed["about"]
    assert not {"CPU time of a step", "pruned"} & shown(untimed, "use mujoco RK4").keys()


@each_case(("factor", "is_offered"), [(0.6, False), (0.4, True)])
def test_a_method_is_offered_if_its_errors_are_half_the_defaults(factor, is_offered):
    def errs(row: Row) -> Row:
        size = {"default": 1.0, "Euler": 1.0, "RK4": factor}.get(row.key.method)
        if size is None or not row.errors:
            return row
        return replace(row, errors=replace(row.errors, attitude=size))

    assert ("use mujoco RK4" in answered(errs)["table"].headings) == is_offered


def left_out(*names: str, unpruned: float = SECONDS_PER_STEP) -> MethodCost:
    """What was measured of MuJoCo's RK4 with and without some passes."""
    key = Key("made-up-top", "mujoco", "RK4")
    cost, varied = StepCost(unpruned, 0.0, unpruned), variation({"left_in": names})
    return MethodCost(key, "a processor", cost, varied, difference=0.0, compared_until=1.0)


def test_turns_until_a_degree_and_the_error_a_turn_stand_first():
    def turning(row: Row) -> Row:
        if not (row.stock and row.motion):
            return row
        turned = {"turns_within_1deg": 3.0, "attitude_a_turn": math.radians(0.5)}
        return replace(row, turns=len(row.motion.t) - 1.0, **turned)

    default = shown(answered(turning), "mujoco default")
    assert (default["1° off after"], default["error a turn"]) == ("3.0 turns", "0.50°")


def test_what_an_engine_cannot_simulate_did_not_blow_up():
    def cannot(row: Row) -> Row:
        if (row.key.scenario, row.key.method) != ("made-up-brick", "default") or not row.stock:
            return row
        return replace(row, outcome="unsupported", errors=None, motion=None)

    found = answered(cannot)
    assert "blew up" not in shown(found, "mujoco default")["on the worst scene"]
    assert "medians of 1 scene;" in found["about"]


def disagreeing(**changed) -> ReportData:
    """As `stocked`; the default that blows up settles on a wrong motion instead."""
    stored = stocked(**changed)
    wrong = [
        replace(v, verdict="disagrees") if v.verdict == "diverges" else v for v in stored.verdicts
    ]
    return report_data(replace(stored, verdicts=wrong))


def test_why_a_default_is_wrong_is_reported_by_name_and_count():
    gathered = disagreeing()
    why = answer(gathered)["why"]
    assert "mujoco default converges to the exact motion on 2 of 2 scenes" in why
    assert "pybullet default does not converge on 2 of 2 scenes, however short the timestep" in why
    assert "however short the timestep: damping (2), joint motor (2)." in why
    # What changes no motion is no reason.
    assert "joint motor" not in answer(gathered, [left_out("joint motor")])["why"]


@pytest.mark.parametrize("acts", [True, False, None])
def test_a_default_that_alters_the_equations_of_motion_is_a_reason(acts):
    why = answer(disagreeing(defaults=[taken_away("joint motor", acts)]))["why"]
    assert ("equations of motion are altered by its joint motor on 1, each alone" in why) == bool(
        acts
    )


def test_no_default_is_blamed_for_a_run_that_blows_up():
    why = answer(report_data(stocked(defaults=[taken_away("joint motor", True)])))["why"]
    assert "pybullet default blows up on 2 of 2 scenes." in why
    assert "joint motor" not in why


def test_a_run_that_did_not_end_ok_has_no_number_in_the_table(gathered):
    shown = cell(gathered, "default", "pybullet")
    assert shown["verdict"] == "diverges"
    at_stock = shown["runs"]["stock"]
    assert (at_stock["timestep"], at_stock["outcome"]) == (STOCK, "diverged")
    assert "errors" not in at_stock


def test_a_run_that_ended_ok_has_its_cost_and_an_error_in_every_signal(gathered):
    runs = cell(gathered, "Euler")["runs"]
    at_stock = runs["stock"]
    assert at_stock["timestep"] == STOCK
    assert at_stock["cost"] == pytest.approx(SECONDS_PER_STEP / STOCK, rel=1e-2)
    assert at_stock["errors"]["attitude"] == pytest.approx(SIZE[1] / 2, rel=1e-2)
    assert list(at_stock["errors"]) == list(EVERYWHERE)
    assert runs["common"] is None
    assert runs["finest"]["timestep"] == pytest.approx(TIMESTEPS[-1], rel=1e-2)


def test_an_error_below_what_the_reference_is_good_for_is_a_bound(gathered):
    bound = cell(gathered, "RK4")["runs"]["finest"]["errors"]["attitude"]
    assert bound == -scene(gathered).solved.solution.uncertainty.attitude < 0
    # The table is JSON, which has no infinite numbers.
    stored = stocked()
    infinite = [replace(row, errors=row.errors and Errors(*[math.inf] * 6)) for row in stored.rows]
    json.dumps(heat_map(report_data(replace(stored, rows=infinite))), allow_nan=False)


def test_the_best_choice_is_the_cheapest_within_the_bounds_or_else_the_most_accurate(gathered):
    choice = best_choice(scene(gathered))
    assert choice.within
    assert choice.runs.label == "mujoco RK4"
    assert choice.row.timestep == TIMESTEPS[0]
    assert choice.row.errors.attitude <= ATTITUDE_WITHIN
    coarse = stocked()
    rows = [r for r in coarse.rows if r.key.method != "RK4" and r.timestep >= TIMESTEPS[2]]
    choice = best_choice(scene(report_data(replace(coarse, rows=rows))))
    assert not choice.within
    assert (choice.runs.label, choice.row.timestep) == ("mujoco Euler", TIMESTEPS[2])


def test_the_best_choice_costs_a_multiple_of_its_engines_default_or_of_the_first_there_is():
    """As RK4 takes steps twice as long as the default, half of it if a step costs the same."""

    def shown(*shipped: str, others: float | None = SECONDS_PER_STEP) -> tuple[str, float | None]:
        stored = stocked()
        verdicts = [
            replace(v, as_shipped=v.as_shipped and v.key.engine in shipped) for v in stored.verdicts
        ]
        dearer = {"mujoco default": 6 * SECONDS_PER_STEP, "pybullet default": 3 * SECONDS_PER_STEP}
        rows = [
            replace(row, seconds_per_step=dearer.get(row.key.label, others)) for row in stored.rows
        ]
        drawn = heat_map(report_data(replace(stored, verdicts=verdicts, rows=rows)))
        (best,) = next(s for s in drawn["scenes"] if s["name"] == "made-up-top")["best"]
        assert (best["label"], best["timestep"]) == ("mujoco RK4", "20 ms")
        return best["default"], best["price"]

    assert shown("mujoco", "pybullet") == ("mujoco", pytest.approx(0.5 / 6, rel=1e-2))
    assert shown("pybullet") == ("pybullet", pytest.approx(0.5 / 3, rel=1e-2))
    assert shown() == ("", None)
    assert shown("mujoco", others=None) == ("mujoco", None)


def test_columns_are_headed_by_the_method_or_the_engine_if_it_is_as_shipped():
    """Euler is of the scene that was not solved."""
    stored = results(methods=(SHIPPED, MadeUp("mujoco", "default-sparse", 1), DYING))
    methods = {pair: replace(m, as_shipped=True) for pair, m in stored.methods.items()}
    columns = heat_map(report_data(replace(stored, methods=methods)))["columns"]
    assert [c["label"] for c in columns] == ["mujoco", "mujoco, sparse", "pybullet", "Euler"]
    assert [c["shipped"] for c in columns] == [True, True, True, False]


def test_in_the_table_of_stock_timesteps_a_cell_is_an_error_or_how_the_run_ended(gathered):
    table = stock_table(gathered)
    (row,) = (row for row in table.rows if row[0].text == "made-up-top")
    euler, rk4 = (math.degrees(SIZE[order] * 2.0**-order) for order in (1, 4))
    shipped, dying, clean, sharp, best = (cell.text for cell in row[1:])
    assert shipped == clean == f"{euler:.2f}°"
    assert dying.startswith(f"{VERDICT['diverges'].sign} diverged at ")
    assert sharp == f"{number(rk4)}°"
    assert best == f"mujoco RK4 20 ms: {number(math.degrees(SIZE[4]))}°"
    (unsolved,) = (row for row in table.rows if row[0].text == "unsolved")
    failed = f"{VERDICT['failed'].sign} {NOTHING}"
    assert [cell.text for cell in unsolved[1:]] == [NOTHING, NOTHING, failed, NOTHING, NOTHING]

    def too_coarse(row: Row) -> Row:
        return replace(row, outcome="unsupported", cause="timestep", errors=None)

    coarse = report_data(replace(stocked(), rows=list(map(too_coarse, stocked().rows))))
    assert stock_table(coarse).rows[0][1].text == "not run"


def test_what_diverged_or_is_lost_is_never_the_best_choice():
    best = stocked()
    rows = [replace(row, without_skill=row.timestep == TIMESTEPS[1]) for row in best.rows]
    rows = [
        replace(row, outcome="diverged", errors=None) if row.timestep == TIMESTEPS[0] else row
        for row in rows
    ]
    choice = best_choice(scene(report_data(replace(best, rows=rows))))
    assert choice.row.timestep == TIMESTEPS[2]


def test_markdown_says_the_same_answer_first(gathered, tmp_path):
    render(stocked(), tmp_path)
    path = tmp_path / "report.md"
    beginning = path.read_text(encoding="utf-8").partition("## ")[0]
    found = answer(gathered)
    for words in (found["lead"], found["about"], found["why"]):
        assert plain(words) in plain(beginning)
    of_answer, first = markdown_tables(path)[:2]
    assert "use mujoco RK4" in [heading.strip() for heading in of_answer[0]]
    assert "mujoco default, 10 ms" in [heading.strip() for heading in first[0]]
    degrees = f"{math.degrees(SIZE[1] / 2):.2f}°"
    assert any(degrees in line for row in first for line in row)


def test_signals_are_there_to_be_chosen_although_no_scene_could_be_solved() -> None:
    """The page's script begins with one of them."""
    stored = stocked()
    rows = [row for row in stored.rows if row.key.scenario not in stored.scenes]
    unsolved = replace(stored, scenes={}, rows=rows, verdicts=[])
    names = [signal["name"] for signal in heat_map(report_data(unsolved))["signals"]]
    assert names == list(EVERYWHERE)


def test_below_which_timestep_rounding_makes_it_worse_is_said_of_every_method() -> None:
    """In the table of its methods, with the bias below; of others in a sentence."""
    ulp, last = float(np.finfo(np.float32).eps), TIMESTEPS[-1]

    def worse(row: Row) -> Row:
        if not row.errors or row.key.engine != "mujoco":
            return row
        error = row.timestep + 16 * last * last / row.timestep
        drifts = {"L_norm": 1.5 * row.steps * ulp}
        return replace(row, errors=Errors(*[1e-3 * error] * 6), drifts=drifts, stock=False)

    plain_rows = stocked()
    stored = replace(plain_rows, rows=[worse(row) for row in plain_rows.rows])
    at_stock = [row for row in plain_rows.rows if row.stock and row.errors]
    again = [replace(row, timestep=1.01 * row.timestep) for row in at_stock]
    found = answer(report_data(replace(stored, rows=[*stored.rows, *again])))
    label = "finer than this makes it worse"
    assert shown(found, "mujoco default")[label].endswith("biased by 1.5 ulp a step")
    assert "Finer than this makes it worse: mujoco" in found["why"]
    assert label not in shown(answer(report_data(plain_rows)), "mujoco default")
