"""Numbers of accuracy and cost, computed from results."""
