"""Compiles what solves exact motions, side by side, before it is needed.

``python -m spincheck.reports.harness.compiling`` does it after an installation, a study before its
first scene: else each worker would compile for itself.
"""

import os
from functools import partial

from ...reference.compiled import compile_flow, compile_kernels, compile_march, is_compiled
from .executors import Executor, LocalWorkers


def compile_side_by_side(executor: Executor) -> None:
    """Compile all kernels that are not compiled yet, in as many workers as share the work."""
    if is_compiled():
        return
    halves = (compile_march, compile_flow)
    for _ in executor.each(partial(executor.call, half) for half in halves):
        pass
    # Both are loaded now: this sees that nothing is missing, and says so to later processes.
    executor.call(compile_kernels)


if __name__ == "__main__":
    with LocalWorkers(min(2, os.cpu_count() or 1)) as workers:
        compile_side_by_side(workers)
