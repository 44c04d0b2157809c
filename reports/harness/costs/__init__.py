"""What steps cost, and what is left out of them costs."""
