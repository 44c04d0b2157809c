"""The command line. Any function may raise `Complaint`: a message for the user, an exit code."""
