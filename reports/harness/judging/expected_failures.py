"""Expected failures (`[[known]]` of a scene's file): excused where they occur, unmet where not."""

from collections.abc import Iterable
from dataclasses import replace

from ....scenarios import Known
from ...results.records import Verdict


def compared_with_expected_failures(
    expected: Iterable[Known], verdict: Verdict, *, cut_short: bool = False
) -> Verdict:
    """Mark a verdict as an expected failure; if it converges, add an unmet expectation.

    An unresolved ladder neither confirms nor refutes an expected failure, nor does one that
    converges to a coarse tolerance because it was cut short.
    """
    key = verdict.key
    for fault in expected:
        if (fault.engine, fault.method) != (key.engine, key.method):
            continue
        if verdict.verdict == fault.verdict:
            return replace(
                verdict, reason=f"{verdict.reason}; known: {fault.reason}", expected_failure=True
            )
        if verdict.verdict == "converges" and not cut_short:
            unmet = f"it converges; delete the [[known]] that it disagrees: {fault.reason}"
            return replace(verdict, unmet=(*verdict.unmet, unmet))
    return verdict
