"""The quick tests on every Python that spincheck is for: `make pythons`.

An interpreter that is not installed is skipped, and said to be.
"""

import nox

nox.options.default_venv_backend = "venv"
nox.options.error_on_missing_interpreters = False


@nox.session(python=["3.11", "3.12", "3.13", "3.14"])
def quick(session: nox.Session) -> None:
    """Install as users do, and run what `make quick` runs."""
    session.install(".[dev]")
    session.run("pytest", "-n", "auto", "--dist", "loadfile", "-m", "not processes and not slow")
