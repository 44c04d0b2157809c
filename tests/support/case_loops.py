"""One test of many cases: all of them are tried, and all that fail are reported by name."""

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from typing import Any

import pytest

Test = Callable[..., None]


def each_case(
    names: str | Sequence[str],
    cases: Iterable[Any] | Mapping[str, Any],
) -> Callable[[Test], Test]:
    """As `pytest.mark.parametrize`, in a single item; skipped only if every case is.

    An item costs more than many a check. Failures come as one exception group, each with its
    traceback and a note of its case.

    Parameters
    ----------
    cases : a value, or one for each of the names; by label if they have one
    """
    keys = (names,) if isinstance(names, str) else tuple(names)
    if not isinstance(cases, Mapping):
        cases = {f"{k}: {getattr(case, 'name', case)!r:.80}": case for k, case in enumerate(cases)}
    by_label = {
        label: {keys[0]: case} if isinstance(names, str) else dict(zip(keys, case, strict=True))
        for label, case in cases.items()
    }
    assert by_label, f"no cases of {names}"

    def decorated(test: Test) -> Test:
        @wraps(test)
        def all_cases(*args: Any, **fixtures: Any) -> None:
            failed: list[BaseException] = []
            skipped: list[str] = []
            for label, case in by_label.items():
                try:
                    test(*args, **fixtures, **case)
                except pytest.skip.Exception as reason:
                    skipped.append(str(reason))
                except (Exception, pytest.fail.Exception) as error:
                    error.add_note(f"case: {label}")
                    failed.append(error)
            if failed:
                raise BaseExceptionGroup(f"{len(failed)} of {len(by_label)} cases", failed)

            if len(skipped) == len(by_label):
                pytest.skip("; ".join(sorted(set(skipped))))

        signature = inspect.signature(test)
        left = [p for name, p in signature.parameters.items() if name not in keys]
        all_cases.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        return all_cases

    return decorated
