"""Motions that somebody recorded: read, compared with the exact motion, explained."""
