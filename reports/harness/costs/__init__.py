"""Measures the cost of steps, and the cost of the passes that they leave out."""
