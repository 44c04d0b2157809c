"""The options and hooks of pytest that `spincheck.suite` is run with."""
