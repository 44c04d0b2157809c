"""How a run differs from the exact motion: over the whole window, and in each interval of it."""
