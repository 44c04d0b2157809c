"""Runs in which something is varied: the scene, its description, or how an engine opens it."""
