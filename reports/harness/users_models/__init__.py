"""Compares users' models as engines hold them with what their files state."""
