"""Runs in which one thing is varied: the scene, its description, or how an engine opens it."""
