"""The cost of steps, and the cost of what is left out of them."""
