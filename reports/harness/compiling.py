"""Compiles what solves exact motions, side by side, before it is needed.

``python -m spincheck.reports.harness.compiling`` does it after an installation, a study before its
first scene: else each worker would compile for itself.
"""

from functools import partial

from ...reference.compiled import compile_flow, compile_kernels, compile_march, is_compiled
from ...reference.kernel import FOLDER
from .executors import Executor, LocalWorkers

#: What shares the work about evenly.
HALVES = (compile_march, compile_flow)


def compile_side_by_side(executor: Executor) -> None:
    """Compile all kernels that are not compiled yet, in as many workers as share the work."""
    # Without a place for machine code every process compiles for itself.
    if FOLDER is None or is_compiled():
        return
    for _ in executor.each(partial(executor.call, half) for half in HALVES):
        pass
    # Both are loaded now: this sees that nothing is missing, and says so to later processes.
    executor.call(compile_kernels)


if __name__ == "__main__":
    with LocalWorkers(len(HALVES)) as workers:
        compile_side_by_side(workers)
