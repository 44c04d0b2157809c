"""A test suite for the continuous integration of physics engines.

``pytest --pyargs spincheck.suite --spincheck-engine my_package:MyEngine`` runs it. Its first
chapter, `test_adapter`, is about the adapter, its second, `test_physics`, about motions:
docs/how-to/suite.md.
"""

from pathlib import Path

__all__ = ["SCENES"]

#: The folder with the scenes of `test_physics`.
SCENES = Path(__file__).parent / "scenes"
