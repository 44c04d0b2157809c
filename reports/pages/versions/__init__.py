"""The page that compares versions of an engine, with its template."""
