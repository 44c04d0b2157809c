"""The timesteps of runs: a ladder of halved timesteps, and the timesteps users get by default."""
