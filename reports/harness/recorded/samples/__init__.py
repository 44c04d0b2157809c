"""Finds mistakes in recording: from the samples alone, or by comparison with the exact motion."""
