"""What a step costs, and what leaving things out saves."""
