"""Makes the runs of a study, compares them with the exact motion, and judges the methods."""
