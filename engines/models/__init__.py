"""A scene as a model file: MJCF and URDF."""
