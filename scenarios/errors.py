"""What is raised about a scenario file that cannot be used."""


class ScenarioError(ValueError):
    """A scenario file is wrong; the message names file, line, table, key, value and rule."""
