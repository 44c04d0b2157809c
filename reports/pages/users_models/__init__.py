"""The page of a user's model, with its template."""
