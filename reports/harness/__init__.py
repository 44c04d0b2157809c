"""Runs, their comparison with the exact motion, and the verdict on a ladder of runs."""
