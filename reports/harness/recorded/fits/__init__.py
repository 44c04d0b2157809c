"""Explains recorded motions by other equations, sensor errors or integrators, fitted to samples."""
