"""The line below pytest's output about scenes: how many items agree, fail, or were not judged."""

from collections.abc import Mapping, Sequence
from typing import Any

#: Name of a property that the report of each scene's item has: whether the item was not run because
#: its outcome is kept from an earlier session.
KEPT = "spincheck_kept"
#: Beginning of the reason of a skipped item if the engine cannot simulate the scene.
UNSUPPORTED = "unsupported"


def summary(stats: Mapping[str, Sequence[Any]]) -> str:
    """Return the line printed below pytest's output; empty if pytest ran no item of a scene.

    Parameters
    ----------
    stats : pytest's reports, by outcome; those of items that are not of scenes are ignored
    """
    passed, failed, skipped = (
        [one for one in stats.get(outcome, ()) if KEPT in _properties(one)]
        for outcome in ("passed", "failed", "skipped")
    )
    own = [*passed, *failed, *skipped]
    scenes = {report.nodeid.partition("::")[0] for report in own}
    unsupported = sum(f"{UNSUPPORTED}: " in str(report.longrepr) for report in skipped)
    kept = sum(_properties(report)[KEPT] for report in own)
    if not own:
        return ""
    return (
        f"spincheck: scenes: {len(scenes)}; items that agree: {len(passed)}, fail: {len(failed)}, "
        f"do not support the scene: {unsupported}, "
        f"skipped otherwise: {len(skipped) - unsupported}"
        + (f"; known from before, not run ('--cache-clear' runs them): {kept}" if kept else "")
    )


def _properties(report: Any) -> dict[str, Any]:
    """Return the user properties of one of pytest's reports, by name; empty if it has none."""
    return dict(getattr(report, "user_properties", ()))
