"""The result file: its records, its SQL tables, and the digests of what results rest on."""
