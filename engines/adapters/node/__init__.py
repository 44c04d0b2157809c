"""Engines that run under node as child processes: each has one `.mjs` file in this folder.

The command `python -m spincheck.engines.adapters.node` installs their npm packages, at the versions
in `package-lock.json`, into the user's cache.
"""

from .discovered import discovered
