"""Expected failures (`[[known]]` of a scene's file): excused where they occur, unmet where not."""

from collections.abc import Iterable
from dataclasses import replace

from ....scenarios import Known
from ...results.verdicts import Verdict


def compared_with_expected_failures(expected: Iterable[Known], verdict: Verdict) -> Verdict:
    """Mark a verdict as an expected failure; if it converges, add an unmet expectation.

    An unresolved verdict neither confirms nor refutes an expected failure.
    """
    key = verdict.key
    for fault in expected:
        if (fault.engine, fault.method) != (key.engine, key.method):
            continue
        if verdict.verdict == fault.verdict:
            quoted = "; ".join(filter(None, (verdict.quoted, f"known: {fault.reason}")))
            return replace(verdict, quoted=quoted, expected_failure=True)
        if verdict.verdict == "converges":
            unmet = f"it converges; delete the [[known]] that it disagrees: {fault.reason}"
            return replace(verdict, unmet=(*verdict.unmet, unmet))
    return verdict
