"""A test suite for the continuous integration of physics engines.

``pytest --pyargs spincheck.suite --spincheck-engine my_package:MyEngine`` runs it. The module
`test_adapter` tests the adapter, `test_physics` tests motions: docs/how-to/suite.md.
"""

from pathlib import Path

__all__ = ["SCENES"]

#: The folder with the scenes of `test_physics`.
SCENES = Path(__file__).parent / "scenes"
