"""Are derivatives that engines give those of the motion: docs/how-to/gradients.md."""
