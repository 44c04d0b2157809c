"""Makes runs in which one thing is varied: the scene, the batch, or how an engine opens it."""
