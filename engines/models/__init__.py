"""Writes scenes as model files: MJCF and URDF."""
