"""Commands that print and compare what result files hold."""
