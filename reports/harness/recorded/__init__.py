"""Recorded motions from anywhere: read, compared with the exact motion, and explained."""
