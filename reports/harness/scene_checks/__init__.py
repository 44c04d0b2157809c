"""Checks a scene and its exact motion against the statements of its file and published values."""
