"""Compares verdicts with the expected failures (`[[known]]`) of a scene's file."""

from collections.abc import Iterable
from dataclasses import replace

from ....scenarios import Known
from ...results.verdicts import Verdict


def compared_with_expected_failures(expected: Iterable[Known], verdict: Verdict) -> Verdict:
    """Return a verdict, compared with the scene's expected failures.

    If the verdict is the expected one, it is marked as expected. If it is `converges` although a
    failure is expected, an unmet expectation is added. A verdict `unresolved` neither confirms nor
    refutes an expected failure.

    Parameters
    ----------
    expected : the expected failures of the scene, of all engines and methods
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
