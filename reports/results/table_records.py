"""Converts records to rows of the tables of a result file, and back."""

import json
import sqlite3
from dataclasses import asdict
from typing import Any

from ...engines import Engine, Method
from ...reference import Solution
from ...scenarios import Errors, Scenario, loads
from .column_values import (
    LARGEST,
    as_result_file_error,
    check,
    from_json,
    scene_name,
    text_of,
    typed,
)
from .cost_records import EffectsCost, PassCost, PassCosts, Ratio, StepCost
from .default_records import DefaultEffect, DefaultEffects
from .motion_blobs import pack, unpack
from .records import Defect, Key, Pair, Row, SignalVerdict, Verdict

_PLAIN_ROW = (
    "engine_version",
    "timestep",
    "outcome",
    "reason",
    "cause",
    "stopped_at",
    "uncertainty",
    "steps",
    "printed",
)
_PLAIN_METHOD = ("order", "attitude_order", "summary", "max_rotation_per_step", "as_shipped")
_PLAIN_VERDICT = ("verdict", "reason", "signal", "order", "limit_error", "tolerance")


def of_scene(scenario: Scenario, solution: Solution) -> dict[str, Any]:
    """A scene and its exact motion, for the table `scenes`."""
    return {
        "scenario": scenario.name,
        "digest": scenario.digest,
        "toml": scenario.text,
        "method": solution.method,
        "uncertainty": json.dumps(asdict(solution.uncertainty)),
        "conditioning": json.dumps(asdict(solution.conditioning)),
        "horizon": solution.horizon,
        "truth": pack(solution.trajectory),
    }


def of_row(row: Row) -> dict[str, Any]:
    """A run, for the table `rows`."""
    return {
        **asdict(row.key),
        **{name: getattr(row, name) for name in _PLAIN_ROW},
        "errors": json.dumps(asdict(row.errors)) if row.errors else None,
        "lost": row.without_skill,
        "stock": row.stock,
        "unasked": json.dumps(row.unasked),
        "drifts": json.dumps(row.drifts) if row.drifts is not None else None,
        "defects": json.dumps({name: asdict(one) for name, one in row.defects.items()})
        if row.defects
        else None,
        "motion": pack(row.motion) if row.motion is not None else None,
    }


def of_verdict(verdict: Verdict) -> dict[str, Any]:
    """A verdict, for the table `verdicts`."""
    return {
        **asdict(verdict.key),
        **{name: getattr(verdict, name) for name in _PLAIN_VERDICT},
        "signals": json.dumps([asdict(one) for one in verdict.signals]),
        "unmet": json.dumps(verdict.unmet),
        "as_shipped": verdict.as_shipped,
        "known": verdict.is_expected_failure,
    }


def of_cost(key: Key, processor: str, cost: StepCost | None) -> dict[str, Any]:
    """The cost of a step, for the table `costs`; None if it cannot be timed."""
    return {
        **asdict(key),
        "processor": processor,
        "seconds_per_step": cost.seconds_per_step if cost else None,
        "seconds_spread": cost.spread if cost else None,
        "wall_seconds_per_step": cost.wall_seconds_per_step if cost else None,
    }


def of_method(engine: Engine, method: Method) -> dict[str, Any]:
    """What an adapter declares of a method, for the table `methods`."""
    return {
        "engine": engine.name,
        "stock_timestep": engine.stock_timestep,
        "method": method.name,
        **{name: getattr(method, name) for name in _PLAIN_METHOD},
        "effects": json.dumps(sorted(method.effects)),
        "requires": json.dumps(sorted(method.requires)),
    }


def of_left_out(cost: EffectsCost | PassCosts) -> dict[str, Any]:
    """What pruning saves, for the table `left_out`."""
    record = asdict(cost)
    return {**record.pop("key"), "kind": type(cost).__name__, "record": json.dumps(record)}


def of_default_effects(effects: DefaultEffects) -> dict[str, Any]:
    """What each default does to a motion, for the table `default_effects`."""
    record = asdict(effects)
    return {**record.pop("key"), "record": json.dumps(record)}


@as_result_file_error
def scene(record: sqlite3.Row) -> tuple[Scenario, Solution]:
    """A record of the table `scenes`."""
    solution = Solution(
        trajectory=unpack(record["truth"]),
        method=record["method"],
        uncertainty=_errors(record["uncertainty"]),
        conditioning=_errors(record["conditioning"]),
        horizon=record["horizon"],
    )
    return loads(record["toml"], scene_name(record)), typed(solution)


@as_result_file_error
def row(record: sqlite3.Row, cost: sqlite3.Row | None = None) -> Row:
    """A record of the table `rows`, with that of its method in `costs`."""
    restored = Row(
        key=key(record),
        errors=_errors(record["errors"]) if record["errors"] else None,
        without_skill=bool(record["lost"]),
        stock=bool(record["stock"]),
        unasked=tuple(from_json(record["unasked"], list)),
        drifts=from_json(record["drifts"], dict) if record["drifts"] else None,
        defects=_defects(record["defects"]) if record["defects"] else None,
        motion=unpack(record["motion"]) if record["motion"] else None,
        seconds_per_step=cost["seconds_per_step"] if cost else None,
        seconds_spread=cost["seconds_spread"] if cost else None,
        wall_seconds_per_step=cost["wall_seconds_per_step"] if cost else None,
        **{name: record[name] for name in _PLAIN_ROW},
    )
    return typed(restored)


@as_result_file_error
def verdict(record: sqlite3.Row) -> Verdict:
    """A record of the table `verdicts`."""
    restored = Verdict(
        key=key(record),
        signals=tuple(typed(SignalVerdict(**one)) for one in from_json(record["signals"], list)),
        unmet=tuple(from_json(record["unmet"], list)),
        as_shipped=bool(record["as_shipped"]),
        is_expected_failure=bool(record["known"]),
        **{name: record[name] for name in _PLAIN_VERDICT},
    )
    return typed(restored)


@as_result_file_error
def method(record: sqlite3.Row) -> tuple[Pair, Method]:
    """A record of the table `methods`: its engine and method, and what was declared of them."""
    declared = {name: record[name] for name in _PLAIN_METHOD}
    restored = Method(
        name=record["method"],
        effects=frozenset(from_json(record["effects"], list)),
        requires=frozenset(from_json(record["requires"], list)),
        **declared | {"as_shipped": bool(declared["as_shipped"])},
    )
    return (text_of(record["engine"]), restored.name), typed(restored)


@as_result_file_error
def stock_timestep(record: sqlite3.Row) -> tuple[str, float] | None:
    """The engine of a record of the table `methods`, and its stock timestep, s, if it has one."""
    timestep = record["stock_timestep"]
    check("stock_timestep", timestep, float | None)
    if timestep is None:
        return None
    if not 0 < timestep < LARGEST:
        raise ValueError(f"stock_timestep: must be positive, got {timestep!r}")
    return text_of(record["engine"]), timestep


@as_result_file_error
def key(record: sqlite3.Row) -> Key:
    """Scene, engine and method of a record of `rows`, `costs` or `verdicts`."""
    restored = point_key(record)
    if not (restored.engine and restored.method):
        raise ValueError("names no engine or no method")
    return restored


def point_key(record: sqlite3.Row) -> Key:
    """Scene, engine and method of a record of `points`; engine and method may be empty."""
    return typed(Key(scene_name(record), record["engine"], record["method"]))


@as_result_file_error
def environment(record: sqlite3.Row) -> tuple[str, str]:
    """A record of the table `environment`."""
    return text_of(record["name"]), text_of(record["value"])


@as_result_file_error
def left_out(record: sqlite3.Row) -> EffectsCost | PassCosts:
    """What pruning saves, of the table `left_out`."""
    fields = from_json(record["record"], dict)
    if record["kind"] == EffectsCost.__name__:
        left_out, ratio = tuple(fields.pop("left_out")), Ratio(**fields.pop("ratio"))
        return typed(EffectsCost(key(record), left_out, ratio=typed(ratio), **fields))
    passes = tuple(typed(PassCost(**one)) for one in fields.pop("passes"))
    return typed(PassCosts(key(record), passes=passes, **fields))


@as_result_file_error
def default_effects(record: sqlite3.Row) -> DefaultEffects:
    """A record of the table `default_effects`."""
    fields = from_json(record["record"], dict)

    def errors(entry: Any) -> Errors | None:
        return None if entry is None else typed(Errors(**entry))

    each = tuple(
        typed(DefaultEffect(one["name"], errors(one["alone"]), errors(one["without"])))
        for one in fields["each"]
    )
    none, every = errors(fields["none"]), errors(fields["all"])
    return typed(DefaultEffects(key(record), fields["timestep"], none, every, each))


def _defects(text: str) -> dict[str, Defect]:
    return {name: typed(Defect(**one)) for name, one in from_json(text, dict).items()}


def _errors(text: str) -> Errors:
    return typed(Errors(**from_json(text, dict)))
