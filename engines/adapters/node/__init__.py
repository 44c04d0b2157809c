"""Engines that run under node, by the child protocol: one `.mjs` file each.

Their packages, of the versions in `package-lock.json`, are in the user's cache once
`python -m spincheck.engines.adapters.node` has put them there.
"""

from .discovered import discovered
