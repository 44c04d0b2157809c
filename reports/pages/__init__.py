"""Makes the report, as HTML and Markdown."""
