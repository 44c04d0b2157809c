"""Checks of a scene, and of its exact motion, against what its file says and what is known."""
