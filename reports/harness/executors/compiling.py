"""Compiles the solver of exact motions, in two processes at once, before it is needed.

It is compiled after an installation, by
``python -m spincheck.reports.harness.executors.compiling``, or else before the first scene of a
study: otherwise each worker would compile for itself.
"""

from collections.abc import Callable
from functools import partial

from ....reference.compiled import compile_flow, compile_kernels, compile_march, is_compiled
from ....reference.kernel import FOLDER
from .executor import Executor
from .local_workers import LocalWorkers

#: The functions that compile the solver's kernels: each compiles about half of them.
HALVES = (compile_march, compile_flow)
#: Time that the slower half takes on a core of its own, including the start of a process, s.
SECONDS = 19.0


def compile_side_by_side(executor: Executor) -> None:
    """Compile the solver of exact motions, by one call for each half of its functions, in parallel.

    Nothing is done if all of it is compiled, or if there is no folder to keep machine code in.

    Parameters
    ----------
    executor : makes the calls; its processes keep the machine code in a common folder
    """
    # Without such a folder every process has to compile for itself.
    if FOLDER is None or is_compiled():
        return
    for _ in executor.each(partial(executor.call, half) for half in HALVES):
        pass
    # This call finds both halves in the folder, compiles what may be missing, and marks the folder
    # as complete.
    executor.call(compile_kernels)


def compile_first(tell: Callable[[str], object]) -> None:
    """Compile the solver, if it is not compiled yet, before this process solves a motion itself.

    Parameters
    ----------
    tell : called before the compilation, with a sentence that announces it
    """
    if is_compiled():
        return
    tell(notice())
    with LocalWorkers(len(HALVES)) as executor:
        compile_side_by_side(executor)


def notice() -> str:
    """Return the sentence that announces a compilation."""
    always = "each time, as no folder can be written (NUMBA_CACHE_DIR names another)"
    when = always if FOLDER is None else "once"
    return f"First, {when}: the solver of exact motions is compiled, roughly {SECONDS:.0f} s."


if __name__ == "__main__":
    with LocalWorkers(len(HALVES)) as workers:
        compile_side_by_side(workers)
