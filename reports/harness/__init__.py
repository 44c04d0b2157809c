"""A run, its comparison with the truth, and the verdict on a ladder of runs."""
