"""Changes of the equations, of sensors and of methods, fitted to a recorded motion."""
