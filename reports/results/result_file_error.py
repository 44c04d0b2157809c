"""The error of a result file that cannot be used."""


class ResultFileError(ValueError):
    """A result file is missing, not one of ours, changed by others, or not writable."""
