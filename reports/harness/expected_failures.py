"""Faults of engines that a scene's file knows of: they are no surprise, and their end is told."""

from collections.abc import Iterable
from dataclasses import replace

from ...scenarios import Known
from ..results.records import Verdict


def held_to_known(known: Iterable[Known], verdict: Verdict) -> Verdict:
    """The verdict with what is known of it; a promise broken where the method converges now.

    A ladder too short to tell says nothing about what is known.
    """
    key = verdict.key
    for fault in known:
        if (fault.engine, fault.method) != (key.engine, key.method):
            continue
        if verdict.verdict == fault.verdict:
            return replace(verdict, reason=f"{verdict.reason}; known: {fault.reason}", known=True)
        if verdict.verdict == "converges":
            broken = f"{key.engine} {key.method} converges, known to disagree: {fault.reason}"
            return replace(verdict, unmet=(*verdict.unmet, broken))
    return verdict
