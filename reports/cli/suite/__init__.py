"""The options and pytest hooks that `spincheck.suite` is run with."""
