"""What adapters of others declare is checked before anything runs; the attribute is named."""

from dataclasses import replace

import pytest
from case_loops import each_case
from command_line import ended
from spincheck.engines import EngineError, discovery
from spincheck.engines.declared import misdeclared
from stepped import METHODS, SteppedEngine

RK4 = METHODS[2]


class Unknown:
    """An attribute that raises when it is read, as a version may."""

    def __get__(self, *_: object) -> str:
        raise ImportError("libmine.so: cannot open shared object file")


#: By the words of the complaint, the attributes that are declared otherwise.
WRONG = {
    "its attribute 'name' must match pattern": {"name": "a@b"},
    "its attribute 'name' must be a valid string, got None": {"name": None},
    "its attribute 'version' must be a valid string, got 2": {"version": 2},
    "its attribute 'version' cannot be read: ImportError: libmine.so": {"version": Unknown()},
    "its attribute 'stock_timestep' must be greater than 0, got -0.1": {"stock_timestep": -0.1},
    "its attribute 'single_precision' must be a valid boolean": {"single_precision": "no"},
    "its attribute 'methods' must be a tuple of Method, got Method(": {"methods": RK4},
    "its attribute 'methods' must be a tuple of Method, got ('RK4',)": {"methods": ("RK4",)},
    "its attribute 'methods' must have at least 1 item": {"methods": ()},
    "its attribute 'methods.0.order' must be a valid integer, got 2.5": {
        "methods": (replace(RK4, order=2.5),)
    },
    "its attribute 'methods.0.effects.0' must be one of gravity, ": {
        "methods": (replace(RK4, effects=frozenset({"gravitas"})),)
    },
    "its methods must have names of their own": {"methods": (RK4, RK4)},
}


#: A module with an engine whose version is no text.
MISDECLARED = """
from stepped import SteppedEngine

class Own(SteppedEngine):
    version = 2

    def __init__(self):
        super().__init__(name="own")
"""


def declaring(attributes: dict[str, object]) -> SteppedEngine:
    computed = {n: a for n, a in attributes.items() if isinstance(a, Unknown)}
    kind = type("Declaring", (SteppedEngine,), computed)
    return kind(**{"name": "own"} | {n: a for n, a in attributes.items() if n not in computed})


def test_what_is_in_order_is_not_complained_of() -> None:
    assert misdeclared(declaring({})) == ""


@each_case(("words", "attributes"), WRONG.items())
def test_the_attribute_is_named(words: str, attributes: dict[str, object]) -> None:
    assert misdeclared(declaring(attributes)).startswith(words)


def test_a_cause_that_is_none_counts_as_unknown() -> None:
    """A result file with another could not be read."""
    assert EngineError("overheated", "heat").cause == ""  # type: ignore[arg-type]
    assert EngineError("blew up", "not-finite").cause == "not-finite"


class Point:
    """An entry point of another package."""

    name, value = "own", "misdeclared_engine"


def test_of_an_installed_package_only_its_own_engine_is_lost(
    monkeypatch: pytest.MonkeyPatch, tmp_path
) -> None:
    (tmp_path / "misdeclared_engine.py").write_text(MISDECLARED, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(discovery, "entry_points", lambda group: [Point()])
    found, absent = discovery._discover.__wrapped__()
    assert "mujoco" in found
    reasons = {one.name: one.reason for one in absent}
    assert reasons["misdeclared_engine"].startswith(
        "its attribute 'version' must be a valid string"
    )


@pytest.mark.processes
def test_one_named_on_the_command_line_is_refused(tmp_path) -> None:
    (tmp_path / "own.py").write_text(MISDECLARED, encoding="utf-8")
    code, _, err = ended("run", "fast-top", "--engine", "own:Own", cwd=tmp_path)
    assert code == 2
    assert "'--engine' own:Own: its attribute 'version' must be a valid string, got 2" in err
