"""Changes of what is computed, and how it is read, that explain steps and recorded motions."""
