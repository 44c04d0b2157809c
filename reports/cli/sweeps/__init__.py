"""Commands that run maps and ensembles."""
