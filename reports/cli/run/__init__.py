"""Commands that run methods on scenes and print the verdicts: `run`, `recommend`."""
