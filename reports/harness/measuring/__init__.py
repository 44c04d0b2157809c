"""What verdicts rest on besides runs: a few numbers, measured once, stored as evidence."""
