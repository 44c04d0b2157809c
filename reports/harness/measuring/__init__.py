"""Measures the evidence that verdicts rest on besides runs: gains of single steps, and replays."""
