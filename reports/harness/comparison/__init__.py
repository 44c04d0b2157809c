"""Compares runs with the exact motion: over the whole window, and between successive samples."""
