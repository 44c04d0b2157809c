"""Inspection of users' models: what engines hold of a file, compared with the file."""
