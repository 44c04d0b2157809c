"""Mistakes that samples show by themselves, or beside their neighbours and the exact motion."""
