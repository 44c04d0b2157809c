"""Agreement, convergence, cost, and the report."""
