"""Reads recorded motions from any source, compares them with the exact one, and explains errors."""
