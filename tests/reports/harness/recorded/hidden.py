"""Recordings with faults that noise or a method's error hides, and what is to be said of them."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from planted_motions import Case, exactly, rates_of
from reported_faults import Arrays, named
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.scenarios import Scenario, from_tables

#: Standard deviations of a measured attitude, rad, and ω, rad/s.
NOISE = 1e-3, 5e-3
#: A number, with ± before it where it is a standard error.
NUMBER = r"±? ?-?\d+\.?\d*(?:e[-+]?\d+)?"
NOISY = {"noise_attitude": repr(NOISE[0]), "noise_omega": repr(NOISE[1])}


@dataclass(frozen=True, eq=False)
class Hidden:
    """A recording with a fault, what is stated of it, and how each sentence on it begins.

    Attributes
    ----------
    numbers : the first in the first sentence after its beginning
    to : how far off they may be; a fiftieth of the largest if 0
    """

    scene: Scenario
    arrays: Callable[[], Arrays]
    said: tuple[str, ...]
    stated: dict[str, str] = field(default_factory=dict)
    order: int = 1
    numbers: tuple[float, ...] = ()
    to: float = 0.0


def right(one: Case) -> Arrays:
    return exactly(one, rates_of(one))


def rounded(arrays: Arrays) -> Arrays:
    return {name: one.round(6) for name, one in arrays.items()}


def noisy(arrays: Arrays) -> Arrays:
    chance = np.random.default_rng(7)
    count = len(arrays["t"])
    turned = Rotation.from_rotvec(chance.normal(0, NOISE[0], (count, 3)))
    q = (Rotation.from_quat(arrays["q"], scalar_first=True) * turned).as_quat(scalar_first=True)
    return arrays | {"q": q, "omega": arrays["omega"] + chance.normal(0, NOISE[1], (count, 3))}


def changed(one: Case, **tables: object) -> Case:
    """The same body in a scene of which some tables are others."""
    document = one.scenario.document.model_dump(mode="json", exclude_none=True)
    return replace(one, scenario=from_tables(document | tables, "changed"))


def check(one: Hidden) -> None:
    """Assert that what is said of a recording is what is to be said."""
    recording = Recording(Path("motion.csv"), one.arrays(), one.stated)
    said = named(judged_motion(one.scene, recording, one.order))
    assert len(said) == len(one.said), said
    assert all(words.startswith(begin) for words, begin in zip(said, one.said, strict=True)), said
    found = re.findall(NUMBER, said[0].removeprefix(one.said[0]))
    # Standard errors are beside measured ones.
    found = [float(text) for text in found if not text.startswith("±")][: len(one.numbers)]
    to = one.to or 0.02 * max(map(abs, one.numbers), default=0.0)
    assert found == pytest.approx(one.numbers, abs=to)
