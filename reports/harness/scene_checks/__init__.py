"""Checks of a scene and its exact motion against what its file states and what is published."""
