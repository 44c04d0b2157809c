"""Installs the packages of the engines under node: `npm ci` in a folder of the user's cache."""

import shutil
import sys

from spincheck.engine import Missing

from ...child.process import end_idle
from ...start_process import run
from .discovered import HERE, discovered, modules_folder

#: Longest time that npm may take, s.
PATIENCE = 3600.0


def main() -> int:
    """Install the npm packages if they are missing, and print each engine's version.

    If an engine does not start, the reason is printed instead.

    It returns the exit code: 3 if npm is not installed, 1 if npm cannot install the packages or an
    engine does not start, else 0.
    """
    npm = shutil.which("npm")
    modules = modules_folder()
    if npm is None:
        print("npm is not installed: engines under node are left out.", file=sys.stderr)
        return 3
    if not modules.is_dir():
        modules.parent.mkdir(parents=True, exist_ok=True)
        for name in ("package.json", "package-lock.json"):
            shutil.copy(HERE / name, modules.parent)
        quietly = ("--no-audit", "--no-fund", "--ignore-scripts", "--loglevel=error")
        done = run([npm, "ci", *quietly], PATIENCE, cwd=modules.parent, stdout=None, stderr=None)
        if done.returncode:
            shutil.rmtree(modules.parent)
            print("npm could not install the engines under node (above: why).", file=sys.stderr)
            return 1
    engines = list(discovered())
    for engine in engines:
        state = engine.reason if isinstance(engine, Missing) else engine.version
        print(f"{engine.name}: {state}")
    end_idle()
    return int(any(isinstance(engine, Missing) for engine in engines))


if __name__ == "__main__":
    sys.exit(main())
