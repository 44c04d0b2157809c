"""The truth: exact solutions and high-precision integration of a top's motion."""
