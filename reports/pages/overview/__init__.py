"""The first page of the report, with its templates."""
