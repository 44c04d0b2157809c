"""Ensembles on the first screen: how errors are distributed over starts and bodies."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from made_up import results
from made_up_ensembles import (
    METHODS,
    MISCHIEF,
    UPRIGHT,
    at_stock,
    ensemble_result,
    scene,
)
from page import unsound
from planted import HeunSession, planted
from plotted import coloured, values_of
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.varied.ensemble import plan_ensemble
from spincheck.reports.pages.analysis.measures import A_TURN, ATTITUDE, TURNS, members_of
from spincheck.reports.pages.analysis.wording import NOTHING, readable
from spincheck.reports.pages.figures.figures import Titled
from spincheck.reports.pages.overview.spread import spread
from spincheck.reports.pages.render import render
from spincheck.reports.results.ensemble_records import Ensemble
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.scenarios import FloatArray

pytestmark = pytest.mark.slow

EULER, RK4, MULTIBODY = METHODS


def curve_of(figure: Titled, name: str) -> tuple[FloatArray, FloatArray]:
    """The points of a distribution's line."""
    curve = next(t for t in figure.parts[0]["data"] if t["name"] == name)
    return values_of(curve["x"]), values_of(curve["y"])


def test_a_file_without_ensembles_shows_nothing_of_them(tmp_path: Path) -> None:
    render(Results({}, {}, [], []), tmp_path)
    assert "kind-1" not in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_a_file_of_ensembles_alone_shows_their_distributions_and_no_scene(tmp_path: Path) -> None:
    render(at_stock(), tmp_path)
    assert {path.name for path in tmp_path.rglob("*.html")} == {"index.html"}
    first = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert first.count('class="plot"') == 1
    assert "assets/plotly.js" in first
    assert MISCHIEF not in first
    assert unsound(tmp_path) == {}


def test_an_ensemble_keeps_what_adapters_declare(tmp_path: Path) -> None:
    """Or a report would know no order and no clamp, and draw no lines for them."""
    definition = Ensemble("disc", 1, seed=7, timestep=0.01)
    engine = planted(HeunSession)
    with open_store(tmp_path / "results.sqlite", create=True) as store:
        plan_ensemble(definition, scene(), Choice((engine,), timed=False), store)
        declared = store.read().methods
    assert declared == {(engine.name, method.name): method for method in engine.methods}


def test_quantiles_are_errors_of_members_and_what_did_not_finish_is_worse_than_any() -> None:
    """Errors 0.01 to 0.20: the 10th, the 19th and the 20th; of 20 p99 would be the largest.

    Of PyBullet's, members 0, 2, … 18 did finish: the tenth of twenty is off by 0.19.
    """
    euler, multibody = members_of(ensemble_result(20).points, [EULER, MULTIBODY])
    degrees = [math.degrees(2 * error) for error in (0.10, 0.19, 0.20)]
    assert euler.quantiles(ATTITUDE) == (*degrees[:2], None, degrees[2])
    assert len(multibody.points) == 20
    assert multibody.quantiles(ATTITUDE) == (degrees[1], math.inf, None, math.inf)


def kinds_of(stored: Results) -> list[dict[str, Any]]:
    """The distributions of the first screen."""
    shown = spread(stored)
    assert shown is not None
    kinds: list[dict[str, Any]] = shown["kinds"]
    return kinds


def test_the_first_screen_has_the_default_and_the_best_of_each_engine() -> None:
    (of_kind,) = kinds_of(at_stock())
    assert (of_kind["kind"], of_kind["members"]) == ("free symmetric", "10")
    rows = [[cell.text for cell in row] for row in of_kind["table"].rows]
    assert [row[0] for row in rows] == [f"{' '.join(pair)}, 10 ms" for pair in METHODS]
    assert of_kind["table"].headings[1:] == ("p50", "p95", "p99", "largest")
    # Of ten members these would be the largest.
    assert all(row[2:4] == [NOTHING, NOTHING] for row in rows)
    median = math.degrees(2 * 0.05)
    assert rows[0][1] == readable(median)
    assert rows[2][-1] == "∞"
    errors, _ = curve_of(of_kind["figure"], "mujoco Euler")
    np.testing.assert_allclose(errors[5], median, rtol=1e-6)
    fixed = replace(at_stock(), ensembles=[ensemble_result()])
    assert spread(fixed) is None


def test_ensembles_of_a_kind_are_one_distribution_without_doubled_members() -> None:
    """Ten members of one scene, twice in the file, and twenty of another."""
    stored = at_stock()
    (disc,) = stored.ensembles
    plate = replace(ensemble_result(20, "plate"), ensemble=Ensemble("plate", 20, 7, None))
    (of_kind,) = kinds_of(replace(stored, ensembles=[disc, disc, plate]))
    assert of_kind["members"] == "30"
    median = math.degrees(2 * 0.08)  # Of 0.01 to 0.10 and 0.01 to 0.20, the fifteenth.
    assert of_kind["table"].rows[0][1].text == readable(median)


def test_kinds_of_motion_have_a_distribution_each() -> None:
    stored = at_stock()
    heavy = replace(stored.ensembles[0], scenario=scene(UPRIGHT, "upright"))
    kinds = kinds_of(replace(stored, ensembles=[heavy, *stored.ensembles]))
    assert [one["kind"] for one in kinds] == ["free symmetric", "heavy symmetric"]


def test_turns_until_a_degree_are_few_and_the_error_a_turn_is_large_for_the_worst() -> None:
    """Of Euler's, 12 turns through 1 to 10; RK4 never; PyBullet's odd ones as far as they went."""
    euler, rk4, multibody = members_of(ensemble_result().points, METHODS)
    assert euler.quantiles(TURNS) == pytest.approx((12 / 5, None, None, 12 / 10))
    assert rk4.quantiles(TURNS) == (math.inf, None, None, math.inf)
    assert (multibody.quantiles(TURNS) or ())[-1] == 0.1
    assert (euler.quantiles(A_TURN) or ())[-1] == pytest.approx(math.degrees(0.1 / 12))
    assert (multibody.quantiles(A_TURN) or ())[-1] == math.inf


def test_the_distribution_rises_at_every_error_and_ends_at_what_finished() -> None:
    (of_kind,) = kinds_of(at_stock())
    go.Figure(coloured(of_kind["figure"].parts[0]))
    errors, shares = curve_of(of_kind["figure"], "mujoco Euler")
    np.testing.assert_allclose(shares, np.arange(0, 101, 10), rtol=1e-6)
    np.testing.assert_allclose(errors[1:], np.degrees(2 * np.arange(1, 11) / 100), rtol=1e-6)
    assert curve_of(of_kind["figure"], "pybullet multibody")[1][-1] == 50.0


def test_ensembles_of_which_no_member_finished_have_no_distribution() -> None:
    stored, ended = at_stock(), {"outcome": "failed", "cause": "crash", "errors": None}
    crashed = tuple(replace(point, **ended) for point in stored.ensembles[0].points)
    assert spread(replace(stored, ensembles=[replace(stored.ensembles[0], points=crashed)])) is None


def test_the_scene_is_linked_only_where_it_has_a_page() -> None:
    stored = at_stock()
    solved = replace(stored, scenes={"disc": next(iter(results().scenes.values()))})
    linked = [kinds_of(one)[0]["scenes"] for one in (stored, solved)]
    assert linked == [[("disc", "")], [("disc", "scenes/disc.html")]]
