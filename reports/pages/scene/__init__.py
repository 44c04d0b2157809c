"""The page of a scene, with its templates."""
