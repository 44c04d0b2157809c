"""The result file: its records, its tables, and what results rest on."""
