"""A defect shows what a run does in an interval, whatever came before it."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from planted import METHOD, HeunSession, planted
from planted_faults import SpunUpFromHalfwaySession, engine_of
from spincheck.engines.engine import Engine
from spincheck.reference import ExactMotion
from spincheck.reports.harness.defects import FARTHEST_TURN, defects
from spincheck.scenarios import Scenario, Trajectory
from spincheck.scenarios.scatter import scattered

EPS = float(np.finfo(float).eps)
BOOK = library_scene("book-middle-axis")
INTERVALS = 40
#: At which the engines of these tests are read, s.
TIMES = BOOK.times[: INTERVALS + 1]
EXACT = ExactMotion(BOOK).outline(TIMES)


def run(engine: Engine, steps: int, scenario: Scenario = BOOK) -> Trajectory:
    """A run of so many steps an interval."""
    timestep = float(TIMES[1]) / steps
    made = engine.run(scenario, METHOD, timestep, steps * np.arange(INTERVALS + 1))
    assert made.outcome == "ok"
    return replace(made.trajectory, t=TIMES)


def largest(motion: Trajectory) -> dict[str, float]:
    found = defects(BOOK, motion, EXACT)
    return {name: float(values.max()) for name, values in vars(found.series).items()}


def test_the_exact_motion_has_none_but_rounding():
    found = defects(BOOK, EXACT, EXACT)
    assert max(values.max() for values in vars(found.series).values()) <= 16 * EPS
    assert found.summary(INTERVALS, EPS)["omega"].floor < 64 * EPS
    np.testing.assert_array_equal(found.t, TIMES[1:])


def test_an_error_made_before_is_no_defect():
    elsewhere = ExactMotion(replace(BOOK, start=replace(BOOK.start, omega_body=...)))
