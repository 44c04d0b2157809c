"""The pages of maps and ensembles, with their templates."""
