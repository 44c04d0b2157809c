"""Inspects users' models: compares the bodies that engines read from a file with the file."""
