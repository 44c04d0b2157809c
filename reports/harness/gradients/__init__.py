"""Compares derivatives that engines compute with those of the motion: docs/how-to/gradients.md."""
