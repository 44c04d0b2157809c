"""Compares engines' derivatives with the exact motion's derivatives: docs/how-to/gradients.md."""
