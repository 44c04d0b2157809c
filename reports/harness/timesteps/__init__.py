"""The timesteps of runs: a ladder of halved ones, and those that users get by default."""
