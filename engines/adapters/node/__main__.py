"""Installs the packages of the engines under node: `npm ci` in a folder of the user's cache."""

import shutil
import subprocess
import sys

from ...child.process import end_idle
from ...missing import Missing
from .discovered import HERE, discovered, modules_folder


def main() -> int:
    """Install what is not there; returns the exit code, 3 where it cannot be done."""
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
        done = subprocess.run([npm, "ci", *quietly], cwd=modules.parent, check=False)
        if done.returncode:
            shutil.rmtree(modules.parent)
            return 3
    for engine in discovered():
        said = engine.reason if isinstance(engine, Missing) else engine.version
        print(f"{engine.name}: {said}")
    end_idle()
    return 0


if __name__ == "__main__":
    sys.exit(main())
