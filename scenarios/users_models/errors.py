"""What is raised about a model file that cannot be read."""


class ModelFileError(ValueError):
    """A model file cannot be read one way; the message names file, line, element and rule."""
